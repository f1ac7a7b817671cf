#!/usr/bin/env bash
# Makes the pictures of GALLERY.md: a short run of each scene, its forces over patch and time (of cells: the pressure).
# Takes the program as its argument; default: the release build.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
program=${1:-target/release/tyrewave}
results=$(mktemp -d)
trap 'rm -rf "$results"' EXIT
for scene in scenes/*.toml; do
    name=$(basename "$scene" .toml)
    [ "$name" = station ] && continue
    picture=patch_force.svg
    settings=(--set rolling.duration=0.3 --set rolling.axle.tolerance=0.5 --set outputs.patch_span=0.01 --set outputs.arrays=false)
    [ "$name" = cells ] && picture=cells_pressure.svg
    if [ "$name" = sound ]; then
        settings+=(--set 'receiver=[{ standard = "cpx" }]' --set 'radiation={ quality = "draft", fmax = 500.0 }')
        settings+=(--set numerics.preset=draft --set numerics.fmax=1000)
    fi
    "$program" run "$scene" --out "$results/$name" -q "${settings[@]}"
    cp "$results/$name/$picture" "profiles/pictures/scene_$name.svg"
done
