#!/bin/sh
# A figure for a paper: three sides in one scale, to print, and the same again a year later.
#   figure.sh SCAN OUT [options of render]
# SCAN  a DICOM folder, a file or a store
# OUT   a folder for results
set -eu
scan=$1 out=$2
shift 2
mkdir -p "$out"

# Three panels, 300 dots an inch: 600x800 pixels are 2 x 2.7 inches of paper. A PDF has words and lines as such.
for file in figure.png figure.pdf; do
  tessera render "$scan" -o "$out/$file" --panel anterior,left,posterior --projection parallel --size 600x800 \
    --dpi 300 --panel-letters --scale-bar --directions letters --background white \
    --caption "Rendered by Tessera from the CT of one patient; all panels have one scale." "$@"
done

# One picture with its measured error in the caption, which reviewers can check.
tessera render "$scan" -o "$out/one.png" --size 800x800 --dpi 300 --scale-bar --directions all --legend --error-caption "$@"

# A year later: the picture again from its own manifest, then seen from another side with everything else as it was.
tessera redraw "$out/one.png" --data "$scan"
tessera redraw "$out/one.png" --data "$scan" -o "$out/one-left.png" --with camera.view=left
