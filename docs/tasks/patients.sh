#!/bin/sh
# Forty patients: the same figure of every scan in a table, and what failed.
#   patients.sh TABLE OUT [options of batch]
# TABLE  a CSV file with the columns id and volumes[0].path, and any key of a scene that differs: camera.view, window, ...
# OUT    a folder for results
set -eu
table=$1 out=$2
shift 2
mkdir -p "$out"

# What all figures share. {id} is the row's.
cat > "$out/scene.json" <<'JSON'
{"tesseraScene": 1,
 "volumes": [{"path": "of-the-row", "transferFunction": "bone", "hideTable": "auto"}],
 "camera": {"view": "anterior", "parallelProjection": true},
 "image": {"size": [600, 800]},
 "annotations": {"title": "{id}", "scaleBar": true, "directions": "letters", "dpi": 300}}
JSON

# First whether every row could be drawn. Then all pictures: those that are there and unchanged are left as they are, so the
# same command goes on after a failure or Ctrl-C.
tessera batch "$table" --scene "$out/scene.json" -o "$out/{id}.png" --dry-run "$@"
tessera batch "$table" --scene "$out/scene.json" -o "$out/{id}.png" --report "$out/report.csv" "$@"
