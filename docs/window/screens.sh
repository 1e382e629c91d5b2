#!/usr/bin/env bash
# Makes the pictures of docs/window anew: the window on a phantom at three sizes, and a folder with several
# volumes from its list to a saved picture, what was found of a lumen and the question before a doubtful one is
# flown, by clicks and steps of a script on a display of its own.
#   docs/window/screens.sh [TESSERA]
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
here=$root/docs/window
tessera=${1:-$root/build/release/tessera}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
export XDG_CONFIG_HOME=$work/config XDG_CACHE_HOME=$work/cache
"$tessera" phantom torso --size 256x192x300 -o torso.zarr -q
# Two volumes: a ball in a box, and two balls of other values. And a pipe with a piece that is as dark as the lung
# which it opens to.
python3 - <<'NII'
import math, os, struct
os.makedirs("scans")
def write(name, size, value):
    x, y, z = size
    head = struct.pack("<i", 348) + bytes(36) + struct.pack("<8h", 3, x, y, z, 1, 1, 1, 1) + bytes(14)
    head += struct.pack("<2h", 4, 16) + bytes(2) + struct.pack("<8f", 1, 1, 1, 2, 0, 0, 0, 0)
    head += struct.pack("<3f", 352, 1, 0) + bytes(348 - 120 - 96) + bytes(0)
    head = head[:252] + struct.pack("<2h", 1, 1) + bytes(24) + struct.pack(
        "<12f", -1, 0, 0, x / 2, 0, -1, 0, y / 2, 0, 0, 2, -z) + bytes(16) + b"n+1\0"
    voxels = [int(value(i, j, k)) for k in range(z) for j in range(y) for i in range(x)]
    open(f"scans/{name}.nii", "wb").write(head + bytes(4) + struct.pack(f"<{len(voxels)}h", *voxels))
ball = lambda p, c, r: sum((a - b) ** 2 for a, b in zip(p, c)) < r * r
write("one-ball", (64, 64, 40), lambda *p: 900 if ball(p, (32, 32, 20), 15) else 60 if min(p) > 3 else 0)
write("two-balls", (72, 48, 44),
      lambda *p: 700 if ball(p, (22, 24, 22), 12) else 1200 if ball(p, (50, 24, 22), 14) else 0)
def pipe(i, j, k):
    x, y, z = i - 30, j - 30, 2 * k - 5
    wall = -1000 + 1040 * min(max(math.dist((x, y, z), (0, 0, min(max(z, 0), 80))) - 5.5, 0), 1)
    if 30 < z < 50 and wall < -800:
        return -840
    return min(wall, -850 if x > 10 or (x > 0 and abs(z - 40) < 5 and abs(y) < 3) else 40)
os.makedirs("pipes")
write("../pipes/pipe", (90, 60, 45), pipe)
NII
cat >torso.txt <<'STEPS'
wait still
wait 300
window shown.ppm
quit
STEPS
cat >list.txt <<'STEPS'
wait choice
wait 2000
window list.ppm
click 700 430
wait 500
wait still
wait 5000
window chosen.ppm
picture chosen.png
quit
STEPS
cat >lumen.txt <<'STEPS'
wait still
line -67 -33 -155 0 38 -200
wait line
place -67 -33 -155
wait still
wait 6000
window lumen.ppm
quit
STEPS
cat >asked.txt <<'STEPS'
wait still
line -15 0 -34 -15 0 34
wait line
fly-to 40
wait still
wait 300
window lumen-asked.ppm
quit
STEPS
# shown NAME DPI SIZE SCRIPT PATH: runs the script; its window's pictures become NAME.png.
shown() {
  xvfb-run -a -s "-screen 0 2700x1700x24 -noreset" bash -c 'echo "Xft.dpi: $1" | xrdb -merge; shift; "$@"' - \
    "$2" "$tessera" view "$5" --size "$3" --script "$4"
}
png() { "$here/ppm_to_png.py" "$1" "$2" 5; }
shown 1280x800 96 1280x800 torso.txt torso.zarr && png shown.ppm "$here/1280x800.png"
shown 800x600 96 800x600 torso.txt torso.zarr && png shown.ppm "$here/800x600.png"
shown 192dpi 192 800x600 torso.txt torso.zarr && png shown.ppm "$here/192dpi.png"
shown list 96 1280x800 list.txt scans && png list.ppm "$here/list.png" && png chosen.ppm "$here/chosen.png"
shown lumen 96 1280x800 lumen.txt torso.zarr && png lumen.ppm "$here/lumen.png"
shown lumen-asked 96 1280x800 asked.txt pipes/pipe.nii && png lumen-asked.ppm "$here/lumen-asked.png"
