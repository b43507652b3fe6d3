#!/usr/bin/env bash
# Builds the Python wheel with the program in it, from a fresh clone: scripts/wheel.sh [FOLDER]
#
# The wheel runs on x86-64 Linux with glibc 2.17 (2014) or newer, the oldest that Rust's standard library supports: zig
# links against the symbols of that version, whichever version this machine has. Needs Rust, Python 3.10 or newer with
# venv, and about ten minutes on two cores. On macOS and Windows, the system's own linker is used.
set -euo pipefail
cd "$(dirname "$0")/.."
out=$(realpath -m "${1:-target/wheels}")
tools=$(mktemp -d)
trap 'rm -rf "$tools"' EXIT

python3 -m venv "$tools"
"$tools/bin/python" -m pip install --quiet 'maturin>=1.9,<2'
portable=()
if [ "$(uname)" = Linux ]; then
    "$tools/bin/python" -m pip install --quiet ziglang
    portable=(--zig --compatibility manylinux2014)
fi
# Paths of this machine would be in the wheel.
export RUSTFLAGS="--remap-path-prefix=$HOME/.cargo=/cargo --remap-path-prefix=$PWD=/machband"
PATH="$tools/bin:$PATH" "$tools/bin/maturin" build --manifest-path python/Cargo.toml --locked --profile dist \
    ${portable[@]+"${portable[@]}"} --out "$out"
ls -l "$out"
