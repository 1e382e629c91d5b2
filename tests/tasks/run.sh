#!/usr/bin/env bash
# Runs a script of docs/tasks/ as a reader would, on small phantoms, and looks at what it made.
#   run.sh TASK PROGRAM
set -euo pipefail
task=$1 program=$2
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
tasks=$here/../../docs/tasks
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
export HOME=$work XDG_CACHE_HOME=$work/cache XDG_CONFIG_HOME=$work/config
mkdir bin
ln -s "$program" bin/tessera
PATH=$work/bin:$PATH

fail() {
  echo "$task: $1" >&2
  exit 1
}
# made FILE...: each is there and not empty.
made() {
  for file; do
    [ -s "$file" ] || fail "expected $file, found $(ls out)"
  done
}
# panels FILE: how many its manifest tells of.
panels() {
  tessera info "$1" --json | python3 -c 'import json, sys; print(len(json.load(sys.stdin)["panels"]))'
}
quick=(--engine native --no-check --set quality.samples=1)

case $task in
  figure)
    tessera phantom torso -q --size 48x40x56 -o torso.zarr
    "$tasks/figure.sh" torso.zarr out "${quick[@]}" --set image.size=[120,160] >said
    made out/figure.png out/figure.pdf out/one.png out/one-left.png
    [ "$(panels out/figure.png)" = 3 ] || fail "expected 3 panels"
    grep -q "^pixels: *equal" said || fail "expected a picture that is drawn again to be equal, found: $(cat said)"
    head -c 5 out/figure.pdf | grep -q '%PDF-' || fail "expected a PDF"
    ;;
  patients)
    for n in 1 2 3; do tessera phantom sphere -q --size "2${n}x20x20" -o "$n.zarr"; done
    printf 'id,volumes[0].path,camera.view\np1,1.zarr,left\np2,2.zarr,\np3,3.zarr,posterior\n' >table.csv
    "$tasks/patients.sh" table.csv out --engine native --no-check
    made out/p1.png out/p2.png out/p3.png out/report.csv
    [ "$(grep -c drawn out/report.csv)" = 3 ] || fail "expected 3 drawn rows, found: $(cat out/report.csv)"
    "$tasks/patients.sh" table.csv out --engine native --no-check
    [ "$(grep -c unchanged out/report.csv)" = 3 ] || fail "expected 3 unchanged rows, found: $(cat out/report.csv)"
    printf 'id,volumes[0].path\np1,1.zarr\nbad,nothing.zarr\n' >table.csv
    if "$tasks/patients.sh" table.csv bad --engine native --no-check; then fail "expected a failure for a missing scan"; fi
    ;;
  colon)
    tessera phantom torso -q --size 128x96x150 -o torso.zarr --curves curves.json
    # Two places of the colon's own line.
    read -r from to < <(python3 - <<'PY'
import json
def lines(part):
    if isinstance(part, dict):
        for key, value in part.items():
            if key == "colon":
                yield value
            yield from lines(value)
    elif isinstance(part, list):
        for value in part:
            yield from lines(value)
def points(part):
    if isinstance(part, list) and len(part) == 3 and all(isinstance(n, (int, float)) for n in part):
        yield part
    elif isinstance(part, (dict, list)):
        for value in part.values() if isinstance(part, dict) else part:
            yield from points(value)
colon = list(points(list(lines(json.load(open("curves.json"))))))
print(*(",".join(str(n) for n in colon[len(colon) * k // 10]) for k in (2, 5)))
PY
    )
    "$tasks/colon.sh" torso.zarr out "$from" "$to" "${quick[@]}" --size 48x36 --fps 1
    made out/colon.json out/unseen.json out/wall.png
    [ -s out/film.mp4 ] || made out/frames/frame-000000.png
    ;;
  *) fail "no such task" ;;
esac
