#!/usr/bin/env bash
# An installation below DESTDIR is whole: the program runs from there, with its modules of there, and what desktops, shells and
# man need is in it and in order.
#   installed_test.sh BUILD_FOLDER
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
source "$here/checks.sh"
build=$1

for component in program window; do
    DESTDIR=$work/root cmake --install "$build" --prefix /usr --component "$component" >/dev/null
done
usr=$work/root/usr
check_layout "$usr"
if [[ -f $usr/lib/tessera/tessera_window_module.so ]]; then check_desktop "$usr"; fi

if named=$(grep -rlF "$(cd "$here/../.." && pwd)" "$usr"); then fail "the folder of the build is named in $named"; fi

mkdir "$work/run"
# Without its modules the program refuses; so those that it takes are the installed ones.
draws "$usr/bin/tessera" "$work/run"
mv "$usr/lib/tessera" "$work/away"
if (cd "$work/run" && "$usr/bin/tessera" render ball -o none.png) 2>"$work/problem"; then fail "a picture without modules"; fi
grep -q "expected a module of tessera" "$work/problem" || fail "without modules: $(<"$work/problem")"
echo "installed: the program draws, documents and entries are in order"
