#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Compiles the decoder to WebAssembly without a runtime: clang, wasm-ld and a few headers and functions of wasi-libc
# (Debian packages clang lld wasi-libc libc++-14-dev-wasm32 libc++abi-14-dev-wasm32 libclang-rt-14-dev-wasm32).
# One scalar module: a build with -msimd128 was not faster (9.0 against 9.4 million triangles a second), since the
# entropy decoder is a chain of dependent decisions. The limit on inlining takes a third of the bytes and a tenth of
# the speed.
# Usage: [NMC_WASM_FLAGS=-msimd128] build_wasm.sh OUTPUT_DIRECTORY
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
out=$1
mkdir -p "$out"
sources=$(ls "$root"/decoder/wasm/*.cpp "$root"/libnmc/common/*.cpp "$root"/libnmc/decode/*.cpp)
# shellcheck disable=SC2086  # the lists of sources and flags are meant to be split
clang++ --target=wasm32-wasi -stdlib=libc++ -std=c++20 -O2 -mbulk-memory -mllvm -inline-threshold=60 \
  -fno-unroll-loops -fno-exceptions -fno-rtti -ffp-contract=off -fno-fast-math -ffunction-sections -fdata-sections \
  -fvisibility=hidden -DNDEBUG -I"$root" -nostartfiles -Wl,--no-entry -Wl,--gc-sections -Wl,--strip-all \
  -Wl,-z,stack-size=131072 ${NMC_WASM_FLAGS:-} $sources -o "$out/nmc_decoder.wasm"
