#!/bin/sh
# A colon to a film: a flight along its centre-line, what of the wall the flight sees, and the wall laid flat.
#   colon.sh SCAN OUT FROM TO [options of the film]
# SCAN  a CT whose colon is filled with air: a DICOM folder, a file or a store
# OUT   a folder for results
# FROM, TO  points in the lumen, x,y,z in mm, as the window shows them under the pointer
set -eu
scan=$1 out=$2 from=$3 to=$4
shift 4
mkdir -p "$out"

# The line through the lumen. It says where the threshold lies and whether the lumen leaks.
tessera centreline "$scan" --from="$from" --to="$to" -o "$out/colon.json"

# What a flight there and back does not see: patches, largest first.
tessera coverage "$scan" --path "$out/colon.json" --both-ways -o "$out/unseen.json"

# The wall around the line, cut open: polyps are bumps, folds are bands.
tessera render "$scan" --path "$out/colon.json" --unfold -o "$out/wall.png"

# The film, lit by a lamp at the eye. Without ffmpeg its frames alone.
film="$out/film.mp4"
command -v ffmpeg >/dev/null || film="$out/frames"
tessera render "$scan" --path "$out/colon.json" --light endoscope --speed 20 -o "$film" "$@"
