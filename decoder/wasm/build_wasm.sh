#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Compiles the decoder to WebAssembly without a runtime: clang, wasm-ld and a few headers and functions of wasi-libc
# (Debian packages clang lld binaryen wasi-libc libc++-14-dev-wasm32 libc++abi-14-dev-wasm32 libclang-rt-14-dev-wasm32).
# One scalar module: with -msimd128 in the two files that the most time goes to a stream takes 10 to 13 % less of it, but
# both modules in one package are 4 kB more with brotli, which takes longer to arrive than it saves (docs/web.md). Only
# those files are compiled for speed, and inlining is limited there too. The linker is called directly, since clang would
# run the wasm-opt that it finds with options of its own.
# Usage: [NMC_WASM_FLAGS=...] [NMC_WASM_FAST_FLAGS=-msimd128] build_wasm.sh OUTPUT_DIRECTORY: more options of clang++ for
# all files, and for those two.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
out=$1
mkdir -p "$out"
objects=$(mktemp -d)
trap 'rm -rf "$objects"' EXIT
for source in "$root"/decoder/wasm/*.cpp "$root"/libnmc/common/*.cpp "$root"/libnmc/decode/*.cpp; do
  name=$(basename "$source" .cpp)
  case $name in
    coefficient_decoder|reconstruct)
      options="-O2 -mllvm -inline-threshold=25 ${NMC_WASM_FAST_FLAGS:-}" ;;
    *) options="-Oz" ;;
  esac
  # shellcheck disable=SC2086  # the options are meant to be split
  clang++ --target=wasm32-wasi -std=c++20 $options ${NMC_WASM_FLAGS:-} -mbulk-memory -fno-unroll-loops -fno-exceptions \
    -fno-rtti -ffp-contract=off -fno-fast-math -ffunction-sections -fdata-sections -fvisibility=hidden -DNDEBUG \
    -DNMC_TABLES_MADE_AT_START -DNMC_WITHOUT_MESSAGES -DNMC_WITHOUT_THREADS -I"$root" -c "$source" -o "$objects/$name.o" &
done
wait  # a file that failed is missed by the linker
wasm-ld -m wasm32 --no-entry --gc-sections --strip-all -z stack-size=131072 "$objects"/*.o \
  -L"$(dirname "$(clang++ --target=wasm32-wasi -print-file-name=libc.a)")" -lc++ -lc++abi -lc "$(clang++ --target=wasm32-wasi -print-libgcc-file-name)" \
  -o "$objects/linked.wasm"
if command -v wasm-opt >/dev/null 2>&1; then
  # Flattened code is put together anew with 1 % fewer bytes, and runs as fast.
  # The linker leaves the first 1024 bytes of memory unused, and memory starts as zeros: both make code smaller.
  wasm-opt -Oz --converge --low-memory-unused --zero-filled-memory --enable-bulk-memory --enable-mutable-globals \
    --enable-sign-ext --enable-simd --enable-nontrapping-float-to-int --flatten --rereloop -Oz -Oz "$objects/linked.wasm" -o "$out/nmc_decoder.wasm"
else
  echo "wasm-opt (Debian package binaryen) is missing: the module works and is 4 % larger" >&2
  cp "$objects/linked.wasm" "$out/nmc_decoder.wasm"
fi
