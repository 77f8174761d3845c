#!/bin/sh
# Installs what is missing, builds everything and runs all tests; ends with ctest's summary.
# Meshes for the tests that need real scans are sought in $NMC_CORPUS (default: ../shared/corpus).
set -eu
cd "$(dirname "$0")/.."

tools/install_packages.sh test
cmake -S . -B build/test -G Ninja -DCMAKE_BUILD_TYPE=Release >/dev/null
cmake --build build/test
exec ctest --test-dir build/test --output-on-failure
