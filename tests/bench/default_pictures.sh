#!/usr/bin/env bash
# What a user waits for: `tessera render STORE -o PICTURE` without a step, every preset, 512 x 512, by the clock and by the
# processor, from process start to process end; the least of so many runs. A Markdown table. The stages of that run by the
# clock: preparing (statistics, camera, levels), loading bricks, drawing (steps that are tried included), measuring errors;
# what is left is the process, opening the store and writing the picture.
#   tests/bench/default_pictures.sh STORE...
#   TESSERA_BENCH_BUILD    build folder (default: build/release)
#   TESSERA_BENCH_RUNS     runs of each (default: 3)
#   TESSERA_BENCH_RENDER   further options of `tessera render`, e.g. "--engine gpu --gl-device software"
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
tessera=${TESSERA_BENCH_BUILD:-$root/build/release}/tessera
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
TIMEFORMAT='%R %U %S'
echo "| volume | preset | seconds by the clock | of the processor | preparing | loading | drawing | measuring | step, voxels | integrator | segments, million |"
echo "|---|---|---|---|---|---|---|---|---|---|---|"
for store in "$@"; do
    for preset in ${TESSERA_BENCH_PRESETS:-bone soft-tissue lung skin vessels}; do
        best=""
        for ((run = 0; run < ${TESSERA_BENCH_RUNS:-3}; ++run)); do
            # shellcheck disable=SC2086
            { time "$tessera" render "$store" -o "$folder/p.png" --preset "$preset" --json -q ${TESSERA_BENCH_RENDER:-} \
                > "$folder/json" 2> "$folder/error" || true; } 2> "$folder/time"
            [[ -s $folder/json ]] || break # it failed
            read -r wall user system < "$folder/time"
            if [[ -z $best ]] || awk "BEGIN { exit !($wall < ${best%% *}) }"; then
                best="$wall $(awk "BEGIN { print $user + $system }")"
                cp "$folder/json" "$folder/best"
            fi
        done
        if [[ -z $best ]]; then
            echo "| $(basename "$store" .zarr) | $preset | $(head -c 60 "$folder/error") | | | | | | | | |"
            continue
        fi
        field() { sed -n "s/.*\"$1\": \"\\{0,1\\}\\([^\",]*\\).*/\\1/p" "$folder/best" | tail -1; }
        seconds() { awk "BEGIN { printf \"%.2f\", $(field "$1") }"; }
        echo "| $(basename "$store" .zarr) | $preset | ${best%% *} | ${best##* } | $(seconds preparing) | $(seconds loading) | $(seconds drawing) | $(seconds checking) | $(field stepVoxels) | $(field integrator) | $(awk "BEGIN { printf \"%.1f\", $(field segments) / 1e6 }") |"
    done
done
