# SPDX-License-Identifier: Apache-2.0
"""What the drivers bench/rd, bench/plot, bench/corpus, bench/speed, bench/guard and bench/results share.

Standard library only; matplotlib is imported by the plotting module alone.
"""
