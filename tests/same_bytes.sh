#!/usr/bin/env bash
# Two programs on the same scenes, byte for byte: `tests/same_bytes.sh OLD NEW`, for changes that must change no result.
# Programs and not stored hashes: the last bits depend on the processor. Eight short runs with each; NEW also rolls them
# on one thread, and goes on with an interrupted one. Arrays, tables and sounds are compared whole; of summary.json what
# was found and the exact work counters, not times. Prints every file that differs and ends with 1 if there is one.
set -uo pipefail
[ $# = 2 ] || { echo "usage: $0 OLD NEW" >&2; exit 2; }
old="$(realpath "$1")" new="$(realpath "$2")"
cd "$(dirname "${BASH_SOURCE[0]}")/.."
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT

short=(--set rolling.warm_up=0.3 --set rolling.duration=0.4)
small=(--set numerics.elements=256)
declare -A options=(
    [default]="default.toml"
    [smooth]="smooth.toml"
    [cobbles]="cobbles.toml"
    [plate]="plate.toml --set contact.slices=half-space"
    [mass]="default.toml --set rolling.axle={load=3400.0,tolerance=0.5,mass=300.0}"
    [vibration]="default.toml --set outputs.vibration={} --set numerics.elements=256"
    [cells]="cells.toml --set numerics.elements=256 --set contact.cells_across=15 --set rolling.axle={load=3400.0,tolerance=0.5}"
    [sound]="sound.toml --set radiation.fmax=500.0 --set numerics.fmax=500.0"
)

# The parts of a summary that no clock has a part in.
exact() {
    awk '/^  "[a-z_]+":/ { kept = /"(outcome|contact|sound|vibration)":/ } /^    "counters":/ { kept = 1 }
         kept { print } /^    }/ { if (kept && counters) kept = 0 } { counters = /"counters":/ || (counters && !/^    }/) }' \
        "$1/summary.json"
}

differing=0
compare() {
    local scene="$1" first="$2" second="$3" file
    [ -d "$first" ] && [ -d "$second" ] || { echo "$scene: a run is missing"; differing=1; return; }
    for file in "$first"/*.{npy,csv,wav}; do
        [ -e "$file" ] || continue
        cmp -s "$file" "$second/${file##*/}" || { echo "$scene: ${file##*/} differs"; differing=1; }
    done
    diff <(exact "$first") <(exact "$second") > "$folder/diff" || { echo "$scene: summary.json differs"; cat "$folder/diff"; differing=1; }
}

for scene in default smooth cobbles plate mass vibration cells sound; do
    read -r -a words <<< "${options[$scene]}"
    roll() { TYREWAVE_CACHE_DIR="$folder/cache.$2" "$1" run "scenes/${words[0]}" "${words[@]:1}" "${short[@]}" --quiet --out "$folder/$scene.$2" --threads "$3"; }
    roll "$old" old 2; roll "$new" new 2; roll "$new" one 1
    compare "$scene" "$folder/$scene.old" "$folder/$scene.new"
    compare "$scene, one thread" "$folder/$scene.new" "$folder/$scene.one"
    echo "$scene: compared"
done

# Interrupted as soon as it rolls, then gone on with.
export TYREWAVE_CACHE_DIR="$folder/cache.new"
"$new" run scenes/default.toml --set rolling.warm_up=0.3 --set rolling.duration=20 --quiet --out "$folder/whole"
"$new" run scenes/default.toml --set rolling.warm_up=0.3 --set rolling.duration=20 --quiet --out "$folder/resumed" &
sleep 1; kill -INT $! 2> /dev/null; wait $!
[ -d "$folder/resumed.partial" ] && "$new" resume "$folder/resumed.partial" --quiet
compare "resumed" "$folder/whole" "$folder/resumed"
[ "$differing" = 0 ] && echo "all the same"
exit "$differing"
