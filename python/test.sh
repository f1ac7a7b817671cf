#!/usr/bin/env bash
# Builds the Python package in a quick profile, in an environment of its own, and tests it against the program. Needs
# python3 with venv, and PyPI; without them it says so and passes.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

target=${CARGO_TARGET_DIR:-target}
mkdir -p "$target"
target=$(cd "$target" && pwd)
environment=$target/python-environment
export CARGO_TARGET_DIR=$target PIP_DISABLE_PIP_VERSION_CHECK=1
# The package's own code is made quickly; the profile's name stands for nothing else.
quick=(--config 'profile.dev.package.tyrewave.opt-level=1')

skip() { echo "skipped: $*"; exit 0; }

python3 -c 'import sys; sys.exit(sys.version_info < (3, 10))' 2>/dev/null || skip "no python3 of 3.10 or newer"
python3 -m venv "$environment" 2>/dev/null || skip "python3 makes no virtual environments here"
bin=$environment/bin
"$bin/pip" install --quiet 'maturin>=1.9.4,<2' numpy pytest xarray matplotlib nbclient nbformat ipykernel mypy ruff \
  || skip "PyPI is out of reach"

"$bin/ruff" format --check python
"$bin/ruff" check python
rm -rf "$target/python-wheels"
"$bin/maturin" build --profile dev "${quick[@]}" --interpreter "$bin/python" --out "$target/python-wheels"
"$bin/pip" install --quiet --no-deps --force-reinstall "$target"/python-wheels/*.whl
"$bin/mypy"
# The stubs say what the extension module has, and how it is called.
(cd "$environment" && "$bin/stubtest" tyrewave._native)
if [ -z "${TYREWAVE_PROGRAM:-}" ]; then
  cargo build "${quick[@]}" --bin tyrewave
  TYREWAVE_PROGRAM=$target/debug/tyrewave
fi
export TYREWAVE_PROGRAM TYREWAVE_CACHE_DIR=$target/influence-cache
"$bin/python" -m pytest "$@"

# The wheel is made for any processor: tried on some without AVX and without AVX-512, with the influence functions that
# this one has fitted, which an emulator would take minutes for.
emulator=$(command -v "qemu-$(uname -m)" || true)
if [ "$(uname -m)" = x86_64 ] && [ -n "$emulator" ]; then
  small='import tyrewave; keys = {"numerics.elements": 64, "rolling.duration": 0.3, "rolling.axle.tolerance": 0.9}
print(tyrewave.Scene.load("scenes/default.toml", set=keys).run().summary["outcome"]["mean_force"], "N")'
  "$bin/python" -c "$small"
  for processor in Nehalem Haswell; do
    "$emulator" -cpu "$processor" "$bin/python" -c "$small" && echo "the wheel runs on a $processor"
  done
else
  echo "skipped: no emulator of a processor without AVX (Debian: qemu-user)"
fi
