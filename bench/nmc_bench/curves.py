# SPDX-License-Identifier: Apache-2.0
"""Rate-distortion curves: interpolation, lower envelopes, Bjontegaard deltas.

A curve is a list of (bytes, error) of one codec while one setting is turned. Between its points bytes are
interpolated linearly in log(bytes) over log(error); beyond its ends it has no value. A peer that has two settings
(triangles and bits) is a family of curves, one for each number of bits, because the number of triangles can be
chosen freely while bits cannot; the envelope is the smallest value of all curves.
"""

import math
from collections import defaultdict

ENVELOPE_PEERS = ("draco", "lindstrom-turk+draco", "meshopt-simplify+draco", "openmesh-quadric+draco",
                  "vcglib-tridecimator+draco")


def pareto_front(points):
    """The points that no other beats in both bytes and error, by falling error."""
    front = []
    for size, error in sorted(points):
        if not front or error < front[-1][1]:
            front.append((size, error))
    return front


def bytes_at(points, error):
    """Bytes at `error` on the front of one curve; None outside of it."""
    front = pareto_front(points)
    for (size_a, error_a), (size_b, error_b) in zip(front, front[1:]):
        if error_a >= error >= error_b:
            share = (math.log(error_a) - math.log(error)) / (math.log(error_a) - math.log(error_b))
            return math.exp((1 - share) * math.log(size_a) + share * math.log(size_b))
    return None


def other_error_at(triples, error):
    """The other error (for example the maximum) of a curve of (bytes, error, other) where the first is `error`."""
    front = []
    for triple in sorted(triples):
        if not front or triple[1] < front[-1][1]:
            front.append(triple)
    for first, second in zip(front, front[1:]):
        if first[1] >= error >= second[1]:
            share = (math.log(first[1]) - math.log(error)) / (math.log(first[1]) - math.log(second[1]))
            return math.exp((1 - share) * math.log(first[2]) + share * math.log(second[2]))
    return None


def bits_of(settings):
    """The part of a peer's settings that cannot be chosen freely."""
    return next((part for part in settings.split() if part.startswith("bits=")), "") if "triangles=" in settings else ""


def curve_families(rows, error="rms"):
    """{(peer, bits): [(bytes, error, other error)]} of the rows of one mesh."""
    other = "max" if error == "rms" else "rms"
    families = defaultdict(list)
    for row in rows:
        if float(row[error]) > 0:
            key = (row["peer"], bits_of(row["settings"]))
            families[key].append((int(row["bytes"]), float(row[error]), float(row[other])))
    return families


def envelope_at(rows, error, kind="rms", peers=ENVELOPE_PEERS):
    """(bytes, peer, other error) of the cheapest peer at `error`; None where none reaches it.

    A file that errs less than asked counts as it is: where the coarsest setting of a peer is already finer than
    `error`, its bytes stand, so that an envelope that ends early does not flatter anyone.
    """
    best = None
    for (peer, _), triples in curve_families(rows, kind).items():
        if peer not in peers:
            continue
        candidates = [(size, other) for size, own, other in triples if own <= error]
        size = bytes_at([triple[:2] for triple in triples], error)
        if size is not None:
            candidates.append((size, other_error_at(triples, error)))
        for size, other in candidates:
            if best is None or size < best[0]:
                best = (size, peer, other)
    return best


def bjontegaard_delta(points, reference_at, low, high, steps=64):
    """Mean ratio of bytes to `reference_at(error)` over log(error) in [low, high], where both exist; None if nowhere.

    Bjontegaard's delta (VCEG-M33, 2001) with log-linear instead of cubic interpolation, as a ratio.
    """
    logs = []
    for i in range(steps):
        error = math.exp(math.log(low) + (math.log(high) - math.log(low)) * (i + 0.5) / steps)
        size, reference = bytes_at(points, error), reference_at(error)
        if size is not None and reference is not None:
            logs.append(math.log(size / reference))
    return math.exp(sum(logs) / len(logs)) if logs else None


def geometric_mean(values):
    values = list(values)
    return math.exp(sum(map(math.log, values)) / len(values)) if values else None
