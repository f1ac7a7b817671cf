#!/usr/bin/env bash
# A program that runs anywhere: linked whole, tried in a root that has nothing else, and, where QEMU's user emulation is
# there, on processors without AVX and without AVX-512, which emulation lets take minutes: they roll with the influence
# functions that were fitted before. With Rust's musl target (`rustup target add x86_64-unknown-linux-musl`) that is what
# it is linked with, otherwise glibc's static library (Debian: libc6-dev). Needs root or user namespaces for the root.
# CARGO_TARGET_DIR and PROFILE (default: release) are taken from the environment.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

machine="$(uname -m)"
profile="${PROFILE:-release}"
target="$machine-unknown-linux-musl"
if [ ! -d "$(rustc --print sysroot)/lib/rustlib/$target" ]; then
    echo "no Rust for $target here: linked with glibc's static library"
    target="$machine-unknown-linux-gnu"
fi
RUSTFLAGS="-C target-feature=+crt-static" cargo build --profile "$profile" --target "$target" --bin tyrewave
folder="$profile"
[ "$profile" = dev ] && folder=debug
program="${CARGO_TARGET_DIR:-target}/$target/$folder/tyrewave"

if ldd "$program" 2>/dev/null | grep -q '=>'; then
    echo "$program wants libraries:" && ldd "$program" && exit 1
fi
ls -l "$program"

root="$(mktemp -d)"
trap 'rm -rf "$root"' EXIT
cp "$program" "$root/tyrewave"
arguments=(--set numerics.elements=64 --set rolling.duration=0.3 --quiet)
enter=(chroot "$root")
[ "$(id -u)" = 0 ] || enter=(unshare --map-root-user chroot "$root")
"${enter[@]}" /tyrewave --version
"${enter[@]}" /tyrewave init /scene --quiet
TYREWAVE_CACHE_DIR=/cache "${enter[@]}" /tyrewave run /scene/scene.toml --out /results "${arguments[@]}"
test -s "$root/results/summary.json"
echo "runs in an empty root"

emulator="$(command -v "qemu-$machine" || command -v "qemu-$machine-static" || true)"
if [ "$machine" = x86_64 ] && [ -n "$emulator" ]; then
    export TYREWAVE_CACHE_DIR="$root/cache"
    for processor in core2duo Haswell; do
        "$emulator" -cpu "$processor" "$program" run "$root/scene/scene.toml" --out "$root/$processor" "${arguments[@]}"
        test -s "$root/$processor/summary.json"
        echo "runs on a $processor"
    done
else
    echo "skipped: no emulator of a processor without AVX (Debian: qemu-user)"
fi
