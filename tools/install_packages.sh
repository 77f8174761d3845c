#!/bin/sh
# Installs what building and testing nmc needs, from Debian's packages. Does nothing when all is there.
# Usage: tools/install_packages.sh build|test
set -eu

build="g++ cmake ninja-build pkg-config libeigen3-dev libembree-dev libopenmesh-dev libtbb-dev libfmt-dev libcli11-dev \
libfast-float-dev nlohmann-json3-dev libstb-dev"
test="catch2 python3 nodejs npm chromium nginx-light clang lld binaryen wasi-libc libc++-14-dev-wasm32 \
libc++abi-14-dev-wasm32 libclang-rt-14-dev-wasm32"

case "${1:-build}" in
  build) wanted="$build" ;;
  test) wanted="$build $test" ;;
  *) echo "usage: $0 build|test" >&2; exit 1 ;;
esac

# A tool that is there already, from wherever, need not come from Debian.
present() {
  case "$1" in
    nodejs) command -v node >/dev/null 2>&1 ;;
    npm) command -v npm >/dev/null 2>&1 ;;
    nginx-light) command -v nginx >/dev/null 2>&1 || [ -x /usr/sbin/nginx ] ;;
    python3) command -v python3 >/dev/null 2>&1 ;;
    *) dpkg-query -W -f='${Status}' "$1" 2>/dev/null | grep -q 'ok installed' ;;
  esac
}
missing=""
for package in $wanted; do
  present "$package" || missing="$missing $package"
done
[ -z "$missing" ] && exit 0

as_root=""
if [ "$(id -u)" != 0 ]; then
  command -v sudo >/dev/null 2>&1 || { echo "these packages are missing, and installing needs root:$missing" >&2; exit 1; }
  as_root="sudo"
fi
echo "installing:$missing"
$as_root apt-get update -qq
DEBIAN_FRONTEND=noninteractive $as_root apt-get install -y -qq --no-install-recommends $missing >/dev/null
