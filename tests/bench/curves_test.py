# SPDX-License-Identifier: Apache-2.0
"""The arithmetic behind every published ratio."""

import os
import tempfile
import unittest

from nmc_bench import curves, summary
from nmc_bench.tables import Table, read_rows


def row(peer, settings, size, rms, maximum=None, mesh="m"):
    return {"mesh": mesh, "peer": peer, "settings": settings, "bytes": str(size), "rms": str(rms),
            "max": str(maximum if maximum is not None else 10 * rms)}


class Interpolation(unittest.TestCase):
    def test_a_power_law_is_interpolated_exactly(self):
        points = [(100, 1e-2), (10000, 1e-4)]
        self.assertAlmostEqual(curves.bytes_at(points, 1e-3), 1000)

    def test_beyond_the_ends_there_is_no_value(self):
        self.assertIsNone(curves.bytes_at([(100, 1e-2), (10000, 1e-4)], 2e-2))
        self.assertIsNone(curves.bytes_at([(100, 1e-2), (10000, 1e-4)], 0.9e-4))

    def test_points_that_cost_more_and_err_more_are_left_out(self):
        points = [(100, 1e-2), (5000, 5e-2), (10000, 1e-4)]
        self.assertAlmostEqual(curves.bytes_at(points, 1e-3), 1000)

    def test_the_other_error_is_taken_at_the_same_place(self):
        self.assertAlmostEqual(curves.other_error_at([(100, 1e-2, 0.1), (10000, 1e-4, 0.001)], 1e-3), 0.01)


class Envelope(unittest.TestCase):
    def test_curves_of_different_depth_are_not_mixed(self):
        # A curve through points of both depths would be cheaper than either at 2e-3.
        rows = [row("a+draco", "triangles=9 bits=8", 100, 4e-3), row("a+draco", "triangles=99 bits=8", 1000, 3e-3),
                row("a+draco", "triangles=9 bits=9", 900, 3e-3), row("a+draco", "triangles=99 bits=9", 1200, 1e-3)]
        size, peer, _ = curves.envelope_at(rows, 2e-3, peers=("a+draco",))
        self.assertEqual(peer, "a+draco")
        self.assertGreater(size, 900)

    def test_the_cheapest_peer_wins(self):
        rows = [row("draco", "bits=8", 5000, 1e-2), row("draco", "bits=12", 50000, 1e-4),
                row("lindstrom-turk+draco", "triangles=50 bits=9", 100, 1e-2),
                row("lindstrom-turk+draco", "triangles=500 bits=9", 10000, 1e-4)]
        size, peer, maximum = curves.envelope_at(rows, 1e-3)
        self.assertEqual(peer, "lindstrom-turk+draco")
        self.assertAlmostEqual(size, 1000)
        self.assertAlmostEqual(maximum, 1e-2)

    def test_where_a_curve_ends_early_its_last_file_stands(self):
        rows = [row("draco", "bits=7", 5000, 2e-2), row("draco", "bits=12", 50000, 1e-4),
                row("lindstrom-turk+draco", "triangles=500 bits=9", 300, 5e-3, 4e-2)]
        self.assertEqual(curves.envelope_at(rows, 1e-2), (300, "lindstrom-turk+draco", 4e-2))

    def test_peers_outside_of_the_envelope_do_not_count(self):
        rows = [row("openctm", "bits=8", 1, 1e-2), row("openctm", "bits=9", 2, 1e-4)]
        self.assertIsNone(curves.envelope_at(rows, 1e-3))


class Bjontegaard(unittest.TestCase):
    def test_half_the_bytes_everywhere_is_a_ratio_of_one_half(self):
        points = [(50, 1e-2), (5000, 1e-4)]
        delta = curves.bjontegaard_delta(points, lambda error: 1 / error, 1e-4, 1e-2)
        self.assertAlmostEqual(delta, 0.5)


class Summary(unittest.TestCase):
    PEERS = [row("draco", "bits=8", 100, 1e-2, 5e-2), row("draco", "bits=12", 10000, 1e-5, 5e-5)]

    def nmc(self, **changes):
        return {"mesh": "m", "settings": "", "target": "0.001", "outcome": "ok", "bytes": "200", "rms": "0.00099",
                "max": "0.004", **changes}

    def test_the_ratio_is_that_of_the_file_to_the_envelope(self):
        result = summary.compare_with_envelope([self.nmc()], self.PEERS, ["m"], targets=(1e-3,))[0]
        self.assertAlmostEqual(float(result["ratio"]), 200 / result["envelope_bytes"], places=2)
        self.assertEqual(summary.max_error_wins([result], 1e-3), (1, 1))

    def test_a_file_that_missed_its_target_has_no_ratio(self):
        result = summary.compare_with_envelope([self.nmc(outcome="target not met")], self.PEERS, ["m"], targets=(1e-3,))[0]
        self.assertNotIn("ratio", result)
        self.assertEqual(summary.mean_ratios([result]), {})


class ResumableTable(unittest.TestCase):
    def test_rows_survive_and_are_not_made_twice(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "t.csv")
            table = Table(path, ["mesh", "bytes"], ["mesh"])
            table.append({"mesh": "a, with comma", "bytes": 1})
            again = Table(path, ["mesh", "bytes"], ["mesh"])
            self.assertTrue(again.contains({"mesh": "a, with comma"}))
            self.assertFalse(again.contains({"mesh": "b"}))
            again.replace({"mesh": "a, with comma", "bytes": 2})
            self.assertEqual([r["bytes"] for r in read_rows(path)], ["2"])


if __name__ == "__main__":
    unittest.main()
