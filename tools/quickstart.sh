#!/bin/sh
# The main job on a real scan: installs what is missing, builds, fetches the scan from a Debian package, encodes and
# decodes it, measures the error and draws original and result beside each other.
# Usage: tools/quickstart.sh [MESH]      (default: the Stanford bunny of Debian's libcgal-demo)
set -eu
cd "$(dirname "$0")/.."

tools/install_packages.sh build
cmake -S . -B build/release -G Ninja -DCMAKE_BUILD_TYPE=Release -DNMC_BUILD_TESTS=OFF >/dev/null
cmake --build build/release --target nmc-encode nmc-decode nmc-compare nmc-render

mkdir -p results
mesh="${1:-}"
if [ -z "$mesh" ]; then
  mesh=results/bunny.off
  if [ ! -s "$mesh" ]; then
    work="$(mktemp -d)"
    trap 'rm -rf "$work"' EXIT
    chmod 755 "$work"
    (cd "$work" && apt-get download -qq libcgal-demo)
    dpkg-deb -x "$work"/libcgal-demo_*.deb "$work/package"
    tar -xzf "$work/package/usr/share/doc/libcgal-dev/data.tar.gz" -C "$work" data/meshes/bunny00.off
    mv "$work/data/meshes/bunny00.off" "$mesh"
  fi
fi

bin=build/release
"$bin/encoder/nmc-encode" "$mesh" -o results/scan.nmc -f --rms-error 0.02% --report results/scan.json
"$bin/decoder/nmc-decode" results/scan.nmc -o results/scan.ply -f
"$bin/encoder/nmc-compare" "$mesh" results/scan.ply
"$bin/encoder/nmc-render" --original "$mesh" --result results/scan.ply -o results/scan.png
echo "picture: results/scan.png (original, result, error)"
