#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks the dependency rule of ARCHITECTURE.md on the text of the sources, and that the page names real files."""
import pathlib
import re
import sys

root = pathlib.Path(sys.argv[1])
allowed = {
    "libnmc/common": {"libnmc/common"},
    "libnmc/decode": {"libnmc/decode", "libnmc/common", "libnmc/include"},
    "libnmc/encode": {"libnmc/encode", "libnmc/common", "libnmc/include"},
}
third_party = re.compile(r"#\s*include\s*[<\"](Eigen/|embree3/|OpenMesh/|oneapi/|tbb/)")
include = re.compile(r"#\s*include\s*\"([^\"]+)\"")
errors = []
count = 0
for folder in ("libnmc", "decoder", "encoder", "bench", "corpus", "tests"):
    for path in sorted((root / folder).rglob("*")):
        if path.suffix not in {".h", ".hpp", ".cpp", ".c"}:
            continue
        count += 1
        name = path.relative_to(root).as_posix()
        text = path.read_text(encoding="utf-8")
        room = "/".join(name.split("/")[:2])
        if not name.startswith(("encoder/", "bench/", "tests/", "corpus/")) and third_party.search(text):
            errors.append(f"{name}: includes a package that only encoder/ and bench/ may use")
        for included in include.findall(text):
            target = "/".join(included.split("/")[:2])
            if room in allowed and included.startswith(("libnmc/", "encoder/", "decoder/")) \
                    and target not in allowed[room]:
                errors.append(f"{name}: includes {included}, which {room} may not use")
            if name.startswith("decoder/") and included.startswith("encoder/"):
                errors.append(f"{name}: includes {included}; the decoder does not know the encoder")
page = (root / "ARCHITECTURE.md").read_text(encoding="utf-8")
for line in page.splitlines():
    cells = [cell.strip() for cell in line.strip("|").split("|")]
    if len(cells) != 4 or "`" not in cells[1]:
        continue
    rooms = re.findall(r"`([^`]+)`", cells[1])
    for file in re.findall(r"`([^`]+\.h)`", cells[3]):
        if not any((root / room / file).is_file() or (root / "libnmc" / file).is_file() for room in rooms):
            errors.append(f"ARCHITECTURE.md: names {file}, which is not in {' or '.join(rooms)}")
print(f"{count} files checked")
for error in errors:
    print(error)
sys.exit(1 if errors or count < 50 else 0)
