#!/usr/bin/env bash
# Draws figures of chapters 4, 7 and 9 of the course notes again, from scans that are there, each joined to one picture
# (docs/measurements/light.md, paths.md): figures.sh [DATA] [OUT]. TESSERA names the program (build/release/tessera); joining takes oiiotool.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../../.." && pwd)
data=${1:-$root/../shared/data}
out=${2:-$root/docs/measurements/light}
tessera=${TESSERA:-$root/build/release/tessera}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

scan() { # NAME SOURCE OPTIONS...
    if [[ ! -e $data/$2 ]]; then
        echo "$1: left out, $data/$2 is absent"
        return 1
    fi
    "$tessera" import "$data/$2" "$work/$1.zarr" --largest "${@:3}" > /dev/null
}
draw() { # PICTURE STORE VIEW ISOSURFACES FUNCTION TRANSPORT SAMPLES OPTIONS...
    cat > "$work/$1.json" << EOF
{"tesseraScene": 1, "volumes": [{"path": "$2.zarr", "transferFunction": {"scalarOpacityUnitDistance": 1, $5}}], "camera": {"view": "$3"},
 "isosurfaces": [$4], "lighting": {"transport": $6,
  "lights": [{"kind": "directional", "direction": [-0.7, 0.8, 0.8], "intensity": 0.9, "softness": 12}],
  "environment": {"sky": "two-tone", "intensity": 0.5, "below": [0.2, 0.18, 0.18]}}}
EOF
    "$tessera" render "$work/$1.json" --engine native --size 192x192 --samples "$7" "${@:8}" --verify quick \
        --background '#101418' -o "$work/$1.png" -q
}
shadow() { # PICTURE STORE VIEW FUNCTION LIGHT LIGHTING OPTIONS...: one hard light from the left and above
    cat > "$work/$1.json" << EOF
{"tesseraScene": 1, "volumes": [{"path": "$2.zarr", "transferFunction": $4}], "camera": {"view": "$3"},
 "shading": {"ambient": 0.15, "diffuse": 0.85, "specular": 0},
 "lighting": {$6 "lights": [{"kind": "directional", "direction": [-0.8, 0.7, 0.9], $5}]}}
EOF
    "$tessera" render "$work/$1.json" --engine native --size 224x224 "${@:7}" --verify quick --background '#101418' \
        -o "$work/$1.png" -q
}
shadows() { # NAME STORE VIEW FUNCTION: without, by rays, by first hits, by a deep map
    shadow "$1-none" "$2" "$3" "$4" '"shadow": false' ''
    shadow "$1-rays" "$2" "$3" "$4" '"shadow": true' '"transport": {"response": "contract"},' --samples 64
    shadow "$1-first" "$2" "$3" "$4" '"shadow": true' '"shadowMap": {"kind": "first"},'
    shadow "$1-deep" "$2" "$3" "$4" '"shadow": true' ''
}
joined() { # PICTURE COLUMNS PICTURES...
    local name=$1 columns=$2 files=()
    shift 2
    for picture in "$@"; do
        files+=("$work/$picture.png")
    done
    oiiotool "${files[@]}" --mosaic:pad=4 "${columns}x$((($# + columns - 1) / columns))" --ch R,G,B -o "$out/$name.png"
}
air='"scalarOpacity": [[-2000, 0]]'
fill() { # EXTINCTION GREY: between skin and bone
    echo "\"scalarOpacity\": [[-300, 0], [-299, $1], [250, $1], [251, 0]], \"rgbTransferFunction\": [[0, $2, $2, $2]]"
}
skin() { # MIRRORED TRANSLUCENT POWER
    echo "{\"value\": -300, \"rgb\": [0.95, 0.8, 0.72], \"finish\": {\"mirrored\": $1, \"roughness\": 0.3, \"translucent\": $2, \"translucentPower\": $3}}"
}
vessels() { # VALUE
    echo "{\"value\": $1, \"rgb\": [0.95, 0.35, 0.3], \"finish\": {\"mirrored\": 0.05, \"roughness\": 0.3}}"
}
bone='{"value": 250, "rgb": [0.9, 0.8, 0.6], "finish": {"mirrored": 0.04, "roughness": 0.5}}'
paths='{"bounces": 12}'
tissue='{"scalarOpacityUnitDistance": 1, "scalarOpacity": [[-200, 0], [0, 0.02], [150, 0.05], [300, 0.9]],
         "rgbTransferFunction": [[-200, 0.9, 0.6, 0.5], [100, 0.9, 0.5, 0.4], [300, 1, 0.95, 0.85]]}'

if scan head ct-head-tilted-dicom --resample-z; then
    for power in 1000 60 8; do
        draw "skin-$power" head anterior "$(skin 0.03 1 $power), $bone" "$air" "$paths" 32 --denoise
    done
    joined translucent-skin 3 skin-1000 skin-60 skin-8

    draw neither head anterior "$(skin 0.03 0.9 60), $bone" "$air" "$paths" 16 --denoise
    draw scattering head anterior "$(skin 0.03 0.9 60), $bone" "$(fill 0.25 1)" '{"bounces": 24, "phase": {"g": 0.9}}' 16 --denoise
    draw attenuation head anterior "$(skin 0.03 0.9 60), $bone" "$(fill 0.12 0)" "$paths" 16 --denoise
    draw both head anterior "$(skin 0.03 0.9 60), $bone" "$(fill 0.25 0.7)" '{"bounces": 24, "phase": {"g": 0.9}}' 16 --denoise
    joined between-isosurfaces 4 neither scattering attenuation both

    draw through head anterior "$(skin 0 1 30), $bone" "$air" "$paths" 24 --denoise
    draw composed head anterior "$(skin 0.04 0.7 30), $bone" "$(fill 0.1 0.8)" "$paths" 24 --denoise
    draw few head anterior "$(skin 0.04 0.7 30), $bone" "$(fill 0.1 0.8)" '{"bounces": 12, "preview": "few"}' 24 --denoise
    draw squared head anterior "$(skin 0.04 0.7 30), $bone" "$(fill 0.1 0.8)" '{"bounces": 12, "preview": "squared"}' 24 --denoise
    joined previews 4 through composed few squared

    if scan avm nifti/CT_AVM.nii.gz; then
        shadows vessels avm left '"auto"'
        shadows bone head anterior '"bone"'
        shadows tissue head anterior "$tissue"
        joined shadows 4 {vessels,bone,tissue}-{none,rays,first,deep}

        draw head-skin head anterior "$(skin 0.04 0 30)" "$air" "$paths" 16 --denoise
        draw vessels-150 avm left "$(vessels 150)" "$air" "$paths" 16 --denoise
        draw vessels-280 avm left "$(vessels 280)" "$air" "$paths" 1
        joined isosurfaces-by-paths 3 head-skin vessels-150 vessels-280
    fi
fi
