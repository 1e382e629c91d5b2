#!/usr/bin/env bash
# For a bare machine with a GPU, a compiler, CMake, Ninja, and the packages of core and render (glm, nlohmann-json, blosc,
# epoxy, Google Benchmark): builds the GPU ray caster, the mirror and benchmarks without importers, picture
#files and viewer, holds the march against the float mirror on every scene, and times frames. Nothing is
#downloaded; the volume is generated. tests/bench/gpu_machine.sh [--quick] [device] auto (default), software,
#or a number --quick a small volume, small pictures, timed once: whether all of it works, in a minute after
#building TESSERA_BENCH_PHANTOM extent of the volume (default: 512x512x749; quick: 96x96x128)
#TESSERA_BENCH_SIZES pixels an axis (default: 256,512,1024; quick: 64) CSV goes to
#build/gpu-results/frame.csv.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
cd "$root"
build=build/gpu-machine results=build/gpu-results
extent=512x512x749 sizes=256,512,1024 repeats=7
if [[ ${1:-} == --quick ]]; then
    extent=96x96x128 sizes=64 repeats=1
    shift
fi
phantom=${TESSERA_BENCH_PHANTOM:-$extent}
mkdir -p "$results"
cmake -G Ninja -S . -B "$build" -DCMAKE_BUILD_TYPE=Release -DTESSERA_WITH_IMPORT=OFF -DTESSERA_WITH_IMAGE_FILES=OFF \
    -DTESSERA_WITH_VIEWER=OFF -DTESSERA_WITH_TESTS=OFF -DTESSERA_WITH_BENCHMARKS=ON
cmake --build "$build" --target frame_bench
"$build/frame_bench" --store "$results/torso-$phantom.zarr" --phantom "$phantom" --device "${1:-auto}" --check 1 \
    --sizes "${TESSERA_BENCH_SIZES:-$sizes}" --repeats "$repeats" > "$results/frame.csv"
cut -d, -f1-4,8-10,12,13 "$results/frame.csv" | column -t -s,
