#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Extracts one shore line of the GSHHG data base as a polyline, one "x y" per line.

    coast_line.py [--file binned_GSHHS_l.nc] [--polygon 2] > coast.txt

Needs ncdump (Debian: netcdf-bin) and the data (Debian: gmt-gshhg-low). Polygon 2 is the mainland of North and
Central America. The file holds the polygons cut at 10 or 20 degree bins; the pieces are joined at equal end
points. The projection is Lambert's azimuthal equal-area one around 45 N, 100 W, as in most maps of that continent.
"""
import argparse
import math
import re
import subprocess
import sys


def variable(dump, name):
    body = re.search(r"^\s" + name + r" = (.*?);", dump, re.M | re.S).group(1)
    # ncdump shows NetCDF's default fill value of a short, -32767, as an underscore; here it is a coordinate.
    return [-32767 if v.strip() == "_" else int(float(v)) for v in body.replace("\n", " ").split(",")]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--file", default="/usr/share/gmt-gshhg/binned_GSHHS_l.nc")
    parser.add_argument("--polygon", type=int, default=2)
    arguments = parser.parse_args()
    names = ["Bin_size_in_minutes", "N_bins_in_360_longitude_range", "Id_of_first_segment_in_a_bin",
             "N_segments_in_a_bin", "Embedded_npts_levels_exit_entry_for_a_segment",
             "Id_of_first_point_in_a_segment", "Id_of_GSHHS_ID", "Relative_longitude_from_SW_corner_of_bin",
             "Relative_latitude_from_SW_corner_of_bin"]
    dump = subprocess.run(["ncdump", "-v", ",".join(names), arguments.file], check=True, capture_output=True,
                          text=True).stdout
    data = dump[dump.index("\ndata:"):]
    (size, columns, first_segment, segment_count, packed, first_point, polygon, dx, dy) = (
        variable(data, name) for name in names)
    unit = size[0] / 60 / 65535  # degrees

    pieces = {}
    for cell, (first, count) in enumerate(zip(first_segment, segment_count)):
        west = (cell % columns[0]) * 65535
        north_row = cell // columns[0]
        south = (180 * 60 // size[0] - 1 - north_row) * 65535
        for s in range(first, first + count):
            if polygon[s] != arguments.polygon:
                continue
            points = []
            for p in range(first_point[s], first_point[s] + (packed[s] >> 9)):
                points.append((west + (dx[p] & 0xFFFF), south + (dy[p] & 0xFFFF)))
            pieces.setdefault(points[0], []).append(points)
    if not pieces:
        sys.exit(f"coast_line.py: {arguments.file} has no polygon {arguments.polygon}")

    # Pieces run the same way round the polygon, and each ends where the next one begins, in the cell beside.
    start = next(iter(pieces))
    line, at = [], start
    while pieces.get(at):
        piece = pieces[at].pop()
        line.extend(piece[:-1])
        at = piece[-1]
    left = sum(len(group) for group in pieces.values())
    if left or at != start:
        print(f"coast_line.py: {left} pieces do not join on", file=sys.stderr)

    longitude0, latitude0 = math.radians(-100), math.radians(45)
    for x, y in line:
        longitude, latitude = math.radians(x * unit), math.radians(y * unit - 90)
        cosine = (math.sin(latitude0) * math.sin(latitude)
                  + math.cos(latitude0) * math.cos(latitude) * math.cos(longitude - longitude0))
        k = math.sqrt(2 / (1 + cosine))
        print(f"{k * math.cos(latitude) * math.sin(longitude - longitude0):.7f} "
              f"{k * (math.cos(latitude0) * math.sin(latitude) - math.sin(latitude0) * math.cos(latitude) * math.cos(longitude - longitude0)):.7f}")


if __name__ == "__main__":
    main()
