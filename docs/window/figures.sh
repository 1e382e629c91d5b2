#!/usr/bin/env bash
# Makes docs/images/window.png and endoscopy.png anew: the window on a phantom, driven by steps in a file instead of a hand, on a display of its own.
#   docs/window/figures.sh [TESSERA]
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
tessera=${1:-$root/build/release/tessera}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"$tessera" phantom torso --size 256x192x300 -o torso.zarr -q
cat >steps.txt <<'STEPS'
wait still
light studio
orbit -30 12
wait still
window window.ppm
light plain
line -67 -33 -155 0 38 -200
wait line
cover
wait line
look-at-patch 2
wait still
wait 4500
window endoscopy.ppm
quit
STEPS
xvfb-run -a -s "-screen 0 1400x900x24" "$tessera" view torso.zarr --size 1100x640 --script steps.txt
for picture in window endoscopy; do
    "$root/docs/window/ppm_to_png.py" $picture.ppm "$root/docs/images/$picture.png"
done
