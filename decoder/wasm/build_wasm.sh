#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Compiles the decoder to WebAssembly, scalar and SIMD, without a runtime: clang, wasm-ld and wasi-libc (Debian packages
# clang lld wasi-libc libc++-14-dev-wasm32 libc++abi-14-dev-wasm32 libclang-rt-14-dev-wasm32).
# Usage: build_wasm.sh OUTPUT_DIRECTORY
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
out=$1
mkdir -p "$out"
sources="$root/decoder/wasm/wasm_exports.cpp"
for room in common decode; do
  for file in "$root"/libnmc/$room/*.cpp; do sources="$sources $file"; done
done
build() {
  # shellcheck disable=SC2086  # the list of sources is meant to be split
  clang++ --target=wasm32-wasi -stdlib=libc++ -std=c++20 -O3 "$@" -fno-exceptions -fno-rtti -ffp-contract=off \
    -fno-fast-math -ffunction-sections -fdata-sections -fvisibility=hidden -DNDEBUG -I"$root" -flto \
    -nostartfiles -Wl,--no-entry -Wl,--gc-sections -Wl,--strip-all -Wl,--lto-O3 \
    -Wl,-z,stack-size=131072 $sources
}
build -o "$out/nmc_decoder.wasm"
build -msimd128 -o "$out/nmc_decoder_simd.wasm"
