#!/usr/bin/env bash
# Draws something to look at. Without arguments: a CT-like phantom. With one: a DICOM folder, a NIfTI file or a
# store, e.g. ./demo.sh ../shared/data/ct-abdomen-dicom; what follows it goes to `tessera import`, e.g. --resample-z.
# With --view first: opens it in a window instead.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
source "$root/cmake/setup.sh"

if [[ ${1:-} == -h || ${1:-} == --help ]]; then
    echo "usage: demo.sh [--view] [FILE|FOLDER|STORE [import options]]"
    exit 0
fi
view=no
if [[ ${1:-} == --view ]]; then
    view=yes
    shift
fi
ensure_packages "$root/cmake/debian-packages.txt"
configure_release
build_release tessera
tessera=$root/build/release/tessera
out=$root/demo-output
mkdir -p "$out"

# Runs a command that makes a store, unless the store is there already, made the same way from the same files.
make_store() { # STORE KEY COMMAND...
    local store=$1 key=$2
    shift 2
    if [[ -f $store/zarr.json && -f $store.made-from && $(<"$store.made-from") == "$key" ]]; then
        echo "Reusing $store"
        return
    fi
    "$@" || exit
    printf '%s\n' "$key" >"$store.made-from"
}

if (($# == 0)); then
    name=torso
    store=$out/torso.zarr
    make_store "$store" "torso 256x192x300" \
        "$tessera" phantom torso --size 256x192x300 -o "$store" --force
else
    input=$(realpath -- "$1") || exit 2
    shift
    name=$(basename -- "$input")
    name=${name%%.*}
    name=${name//[^A-Za-z0-9_-]/_}
    if [[ -f $input/zarr.json ]]; then
        store=$input
    else
        store=$out/$name.zarr
        # Names, sizes and times of the files stand for their content.
        key=$( (printf '%s\n' "$input" "$@"; [[ -e $input ]] && find "$input" -type f -printf '%p %s %T@\n' | sort) |
            sha256sum | cut -c1-32)
        make_store "$store" "$key" "$tessera" import "$input" "$store" --largest --force "$@"
    fi
fi

if [[ $view == yes ]]; then
    exec "$tessera" view "$store"
fi
echo
"$tessera" info "$store"
echo
preset=auto crop=()
if "$tessera" info "$store" --json --quiet | grep -q '"unit": "HU"'; then
    preset=skin crop=(--crop body) # without the table
fi
pictures=()
for view in anterior left posterior; do
    picture=$out/$name-$view.png
    "$tessera" render "$store" -o "$picture" --view "$view" --light studio "${crop[@]}"
    pictures+=("$picture")
done
echo "Pictures:"
printf '    %s\n' "${pictures[@]}"

echo "Try next:"
echo "    $tessera view $store"
echo "    $tessera render $store -o $out/$name-$preset.png --preset $preset --view right ${crop[*]}"
echo "    $tessera render $store -o $out/$name-small-budget.png --gpu-memory 16MiB --explain"
echo "    $tessera render $store -o $out/$name-large.exr --size 1024x1024 --projection parallel --background transparent"
