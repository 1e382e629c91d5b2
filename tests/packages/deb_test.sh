#!/usr/bin/env bash
# Debian's packages: lintian finds nothing but what the overrides say, and each has what it needs.
#   deb_test.sh FOLDER   with the packages of cmake/packages/make.sh
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
source "$here/checks.sh"
shopt -s nullglob
program=("$1"/tessera_*.deb) window=("$1"/tessera-window_*.deb)
[[ ${#program[@]} == 1 ]] || fail "expected one tessera_*.deb in $1, found ${#program[@]}"

depends() { dpkg-deb -f "$1" Depends | tr ',' '\n' | sed 's/^ *//; s/ .*//'; }
for library in libc6 libstdc++6 libepoxy0 libvtk9.1 libopenimageio2.4; do
    depends "${program[0]}" | grep -qx "$library" || fail "tessera does not depend on $library"
done
if depends "${program[0]}" | grep -qxE 'libglfw3|libgl1|libegl1'; then fail "tessera depends on OpenGL or a display"; fi
if ((${#window[@]})); then
    version=$(dpkg-deb -f "${program[0]}" Version)
    dpkg-deb -f "${window[0]}" Depends | grep -qF "tessera (= $version)" || fail "tessera-window does not depend on tessera"
    depends "${window[0]}" | grep -qx libglfw3 || fail "tessera-window does not depend on libglfw3"
fi
for package in "$1"/*.deb; do
    if dpkg-deb -c "$package" | awk '{ print $4, $5 }' | sort -u | grep -v "^$(date -u -d "@$(epoch)" '+%F %H:%M')\$"; then
        fail "$package: files of another time"
    fi
done
if ! has lintian; then
    echo "lintian is missing: not run"
    exit 0
fi
lintian --fail-on error,warning --no-cfg --allow-root "$1"/*.deb
echo "packages: lintian finds nothing"
