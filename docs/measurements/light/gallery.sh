#!/usr/bin/env bash
# Draws the pictures of docs/measurements/light.md: gallery.sh [DATA] [OUT]; DATA holds the scans that docs/measurements/light.md names (absent ones are left
# out), OUT is docs/measurements/light unless it is given. TESSERA names the program (build/release/tessera).
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../../.." && pwd)
data=${1:-$root/../shared/data}
out=${2:-$root/docs/measurements/light}
tessera=${TESSERA:-$root/build/release/tessera}
stores=$(mktemp -d)
trap 'rm -rf "$stores"' EXIT
mkdir -p "$out"

draw() { # NAME STORE OPTIONS...: in every look
    local name=$1 store=$2 look
    shift 2
    for look in plain studio soft dramatic cinematic; do
        local samples=()
        [[ $look == cinematic ]] && samples=(--samples 128)
        "$tessera" render "$store" --verify quick --size 384x384 --light "$look" "${samples[@]}" "$@" -o "$out/$name-$look.png"
    done
}
scan() { # NAME SOURCE OPTIONS...
    local name=$1 source=$data/$2
    shift 2
    if [[ ! -e $source ]]; then
        echo "$name: left out, $source is absent"
        return
    fi
    "$tessera" import "$source" "$stores/$name.zarr" --largest --resample-z > /dev/null
    draw "$name" "$stores/$name.zarr" "$@"
}
scan abdomen ct-abdomen-dicom --preset bone
if [[ -e $stores/abdomen.zarr ]]; then # tissue that sends light, and the same without
    cp "$root/docs/measurements/light/glow.json" "$stores/glow.json"
    sed 's/, "emission": \[[^]]*\]//; s/, "emission": [0-9.]*//' "$stores/glow.json" > "$stores/glow-without.json"
    for scene in glow glow-without; do
        "$tessera" render "$stores/$scene.json" --verify quick -o "$out/$scene.png"
    done
fi
scan chest ct-thorax-dicom --preset skin
scan ribs ct-thorax-dicom --preset bone
scan lungs ct-thorax-dicom --preset lung
scan vessels nifti/CT_AVM.nii.gz --preset auto
scan head ct-head-tilted-dicom --preset bone
