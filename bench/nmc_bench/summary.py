# SPDX-License-Identifier: Apache-2.0
"""nmc beside the peers' envelope, mesh by mesh and target by target."""

from collections import defaultdict

from nmc_bench import curves
from nmc_bench.tables import significant, write_rows

TARGETS = (1e-3, 5e-4, 2e-4, 1e-4, 5e-5)
V_DMC_RATIO = {1e-3: 1.19, 5e-4: 0.89, 2e-4: 0.67, 1e-4: 0.64, 5e-5: 0.77}  # test model 14, docs/results.md says how

COLUMNS = ["mesh", "target", "nmc_outcome", "nmc_bytes", "nmc_rms", "nmc_max", "envelope_bytes", "envelope_peer", "ratio",
           "envelope_max_at_equal_rms", "envelope_bytes_at_equal_max", "ratio_at_equal_max"]


def rows_by_mesh(rows):
    grouped = defaultdict(list)
    for row in rows:
        grouped[row["mesh"]].append(row)
    return grouped


def with_fixed_envelope(peer_rows, fixed_rows):
    """`peer_rows`, and for meshes on which no simplifier has been run here the envelope's rows of the fixed points."""
    done = {row["mesh"] for row in peer_rows if row["peer"].endswith("+draco")}
    return peer_rows + [row for row in fixed_rows if row["peer"] in curves.ENVELOPE_PEERS and row["mesh"] not in done]


def compare_with_envelope(nmc_rows, peer_rows, meshes, settings="", targets=TARGETS):
    """One dictionary (COLUMNS) for each mesh and target; fields that do not exist are empty."""
    peers_of, nmc_of = rows_by_mesh(peer_rows), rows_by_mesh(nmc_rows)
    table = []
    for mesh in meshes:
        for target in targets:
            row = {"mesh": mesh, "target": f"{target:g}"}
            envelope = curves.envelope_at(peers_of[mesh], target)
            if envelope:
                row.update(envelope_bytes=round(envelope[0]), envelope_peer=envelope[1],
                           envelope_max_at_equal_rms=significant(envelope[2], 4))
            nmc = next((r for r in nmc_of[mesh] if float(r["target"]) == target and r["settings"] == settings), None)
            if nmc:
                row.update(nmc_outcome=nmc["outcome"], nmc_bytes=nmc["bytes"], nmc_rms=nmc["rms"], nmc_max=nmc["max"])
            if nmc and nmc["outcome"] == "ok":
                if envelope:
                    row["ratio"] = significant(int(nmc["bytes"]) / envelope[0], 4)
                at_equal_max = curves.envelope_at(peers_of[mesh], float(nmc["max"]), "max")
                if at_equal_max:
                    row.update(envelope_bytes_at_equal_max=round(at_equal_max[0]),
                               ratio_at_equal_max=significant(int(nmc["bytes"]) / at_equal_max[0], 4))
            table.append(row)
    return table


def write(path, rows):
    write_rows(path, COLUMNS, rows)


def mean_ratios(rows, field="ratio"):
    """{target: (geometric mean, number of meshes)} of the rows that have the field."""
    values = defaultdict(list)
    for row in rows:
        if row.get(field):
            values[float(row["target"])].append(float(row[field]))
    return {target: (curves.geometric_mean(found), len(found)) for target, found in values.items()}


def max_error_wins(rows, target):
    """(meshes where nmc's max error at the target is no worse than the envelope's at equal RMS, meshes compared)."""
    compared = [row for row in rows if float(row["target"]) == target and row.get("envelope_max_at_equal_rms")
                and row.get("nmc_outcome") == "ok"]
    return sum(float(row["nmc_max"]) <= float(row["envelope_max_at_equal_rms"]) for row in compared), len(compared)


def bjontegaard(nmc_rows, peer_rows, mesh, settings=""):
    """Mean ratio of nmc's bytes to the envelope's over the targets' range of RMS."""
    points = [(int(r["bytes"]), float(r["rms"])) for r in nmc_rows
              if r["mesh"] == mesh and r["settings"] == settings and r["bytes"] and r["rms"]]
    peers = [row for row in peer_rows if row["mesh"] == mesh]

    def reference(error):
        envelope = curves.envelope_at(peers, error)
        return envelope[0] if envelope else None

    return curves.bjontegaard_delta(points, reference, TARGETS[-1], TARGETS[0]) if points and peers else None


def as_text(rows):
    """The table for a terminal: nmc bytes / envelope bytes = ratio, per target."""
    targets = sorted({float(row["target"]) for row in rows}, reverse=True)
    by_key = {(row["mesh"], float(row["target"])): row for row in rows}
    meshes = list(dict.fromkeys(row["mesh"] for row in rows))
    lines = ["nmc bytes / envelope bytes = ratio at equal RMS (of the diagonal)",
             f"{'':20}" + "".join(f"{target:>24g}" for target in targets)]
    for mesh in meshes:
        line = f"{mesh:20}"
        for target in targets:
            row = by_key.get((mesh, target), {})
            ratio = row.get("ratio")
            nmc = row.get("nmc_bytes") if ratio or row.get("nmc_outcome") == "ok" else "-"
            cell = f"{nmc or '-'}/{row.get('envelope_bytes', '-')}"
            line += f"{cell:>17}{'=' + format(float(ratio), '.3f') if ratio else '':>7}"
        lines.append(line)
    ratios = mean_ratios(rows)
    line = f"{'geometric mean':20}"
    for target in targets:
        line += f"{ratios[target][0]:>18.3f} ({ratios[target][1]:>2}) " if target in ratios else f"{'-':>24}"
    lines.append(line)
    line = f"{'max error no worse':20}"
    for target in targets:
        wins, compared = max_error_wins(rows, target)
        line += f"{f'{wins} of {compared}':>24}" if compared else f"{'-':>24}"
    lines.append(line)
    return "\n".join(lines)
