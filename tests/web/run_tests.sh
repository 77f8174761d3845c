#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# One suite of the web tests: installs what package-lock.json names, builds the package, runs the suite. Without the
# programs it needs it is skipped (exit code 77), but fails where $CI is set.
# Usage: run_tests.sh decoder|package|viewer
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)

needed="node npm clang++ wasm-ld wasm-opt"
[ "$1" = decoder ] || needed="$needed chromium nginx"
PATH="$PATH:/usr/sbin:/sbin"
for name in $needed; do
  command -v "$name" >/dev/null 2>&1 && continue
  echo "web tests: $name is missing (tools/install_packages.sh test)" >&2
  [ -z "${CI:-}" ] && exit 77
  exit 1
done

install() {
  [ "$1/node_modules/.package-lock.json" -nt "$1/package-lock.json" ] ||
    (cd "$1" && npm install --no-save --no-audit --no-fund --loglevel=error)
}
install "$root/decoder/js"
(cd "$root/decoder/js" && node build.mjs)
if [ "$1" = decoder ]; then
  cd "$root/decoder/js"
  exec node --test
fi
install "$here"
install "$root/viewer"
cd "$here"
if [ "$1" = viewer ]; then
  node --test steps.test.mjs
fi
exec node --test "$1.test.mjs"
