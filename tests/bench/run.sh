#!/usr/bin/env bash
# Builds all benchmarks and runs them; CSV and tables go to build/bench-results. On 2 cores it takes a quarter of an
# hour and is only worth as much as the machine is quiet: the load is printed beside every figure.
#   tests/bench/run.sh [micro|frame|interactive|peer|six|native|paths|defaults ...]      the first four where none is named
#   TESSERA_BENCH_SCANS   six: folder with ct-abdomen-dicom and ct-thorax-dicom; scenes of scans that are not there
#                         are left out
#   TESSERA_BENCH_TRUTHS  six: folder of references, which are made where they are absent: minutes each (default:
#                         build/bench-results)
#   TESSERA_BENCH_SIX     six: further options of six_scenes, e.g. "--quick 1" or "--truths-only 1"
#   TESSERA_BENCH_PATHS   paths: scenes to compare with other ways, STORE:PRESET,... (default: bone and skin of each
#                         volume in build/bench-data)
#   TESSERA_BENCH_DEVICE  auto, software or a number (default: software, so that figures compare)
#   TESSERA_BENCH_BUILD   build folder (default: build/release)
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
cd "$root"
build=${TESSERA_BENCH_BUILD:-build/release}
device=${TESSERA_BENCH_DEVICE:-software}
results=build/bench-results
store=build/bench-data/torso-thorax.zarr
mkdir -p "$results" build/bench-data

cmake --preset release -B "$build" -DTESSERA_WITH_BENCHMARKS=ON
what=("$@")
[[ ${#what[@]} -gt 0 ]] || what=(micro frame interactive peer)
targets=(tessera)
for part in "${what[@]}"; do
    case $part in
    peer) target=vtk_peer ;;
    six) target=six_scenes ;;
    defaults) target=tessera ;;
    paths) target=path_bench; targets+=(path_contest path_peer) ;;
    *) target=${part}_bench ;;
    esac
    if grep -q "^build $target:" "$build/build.ninja"; then targets+=("$target"); fi
done
cmake --build "$build" --target "${targets[@]}"

{
    date -u +%FT%TZ
    git describe --always --dirty
    grep -m1 'model name' /proc/cpuinfo
    nproc
    uptime
} > "$results/machine.txt"

for part in "${what[@]}"; do
    case $part in
    native)
        [[ -d $store ]] || "$build/tessera" phantom torso --size 512x512x749 -o "$store" -q
        for preset in bone soft-tissue lung skin vessels; do
            for light in off on; do
                echo "== torso, $preset, light $light"
                "$build/native_bench" --store "$store" --preset "$preset" --light "$light"
            done
        done | tee "$results/native.txt"
        ;;
    paths) # of all volumes that are there
        [[ -d $store ]] || "$build/tessera" phantom torso --size 512x512x749 -o "$store" -q
        for volume in build/bench-data/*.zarr; do
            "$build/path_bench" --store "$volume" --samples 4,16,64 --light 16
        done | tee "$results/paths.md"
        volumes=(build/bench-data/*.zarr)
        scenes=$(printf '%s:bone,' "${volumes[@]}")$(printf '%s:skin,' "${volumes[@]}")
        "$build/path_contest" --scenes "${TESSERA_BENCH_PATHS:-${scenes%,}}" | tee "$results/paths-contest.md"
        # Cycles and POV-Ray, where they are installed; Debian's own Python has what grids need.
        /usr/bin/python3 tests/bench/path_peers.py --build "$build" --work "$results/paths-peers" --edge 128 \
            --per-voxel 0.5 --converged 256 --size 96 "${volumes[@]/%/:bone}" | tee "$results/paths-peers.md"
        ;;
    defaults)
        [[ -d $store ]] || "$build/tessera" phantom torso --size 512x512x749 -o "$store" -q
        tests/bench/default_pictures.sh build/bench-data/*.zarr | tee "$results/defaults.md"
        ;;
    micro)
        "$build/micro_bench" --device "$device" --benchmark_min_time=0.2 --benchmark_repetitions=3 \
            --benchmark_enable_random_interleaving=true --benchmark_counters_tabular=false \
            --benchmark_out="$results/micro.json" --benchmark_out_format=json
        ;;
    frame)
        "$build/frame_bench" --store "$store" --device "$device" --only bone --fetch hardware --repeats 5 \
            > "$results/frame.csv"
        "$build/frame_bench" --store "$store" --device "$device" --only plain --sizes 128,256 --repeats 3 \
            > "$results/frame-fetch.csv"
        cat "$results/frame.csv" "$results/frame-fetch.csv"
        ;;
    interactive)
        # frame_bench makes the store where it is absent.
        [[ -d $store ]] || "$build/frame_bench" --store "$store" --device "$device" --only bone --sizes 128 --repeats 1 \
            > /dev/null
        "$build/interactive_bench" --store "$store" --device "$device" --gpu-memory 64MiB | tee "$results/interactive.csv"
        ;;
    peer)
        if [[ ! -x $build/vtk_peer ]]; then
            echo "peer: left out, VTK's rendering is not installed"
        elif ! command -v xvfb-run > /dev/null; then
            echo "peer: left out, xvfb-run is not installed (apt install xvfb xauth)"
        else
            xvfb-run -a "$build/vtk_peer" --store "$store" --device software --rounds 5 --shifts 1 \
                --csv "$results/vtk_peer.csv" | tee "$results/vtk_peer.md"
        fi
        ;;
    six)
        if [[ ! -x $build/six_scenes ]] || ! command -v xvfb-run > /dev/null; then
            echo "six: left out, VTK's rendering or xvfb-run is not installed (apt install xvfb xauth)"
            continue
        fi
        [[ -d $store ]] || "$build/tessera" phantom torso --size 512x512x749 -o "$store"
        stores=torso=$store
        for scan in abdomen chest=thorax; do
            at=build/bench-data/${scan%=*}.zarr from=${TESSERA_BENCH_SCANS:-}/ct-${scan#*=}-dicom
            if [[ ! -d $at && -n ${TESSERA_BENCH_SCANS:-} && -d $from ]]; then "$build/tessera" import "$from" "$at"; fi
            if [[ -d $at ]]; then stores+=,${scan%=*}=$at; fi
        done
        # shellcheck disable=SC2086 # options are words
        xvfb-run -a "$build/six_scenes" --stores "$stores" --truths "${TESSERA_BENCH_TRUTHS:-$results}" \
            --csv "$results/six.csv" ${TESSERA_BENCH_SIX:-} | tee "$results/six.md"
        ;;
    *)
        echo "run.sh: expected micro, frame, interactive, peer or six, found $part" >&2
        exit 2
        ;;
    esac
done
