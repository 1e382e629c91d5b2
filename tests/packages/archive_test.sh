#!/usr/bin/env bash
# The archive runs wherever it is unpacked: with an empty environment, by a link, without any of its libraries in the system's
# folders where that can be tried, and its list of software is true.
#   archive_test.sh FOLDER   with the packages of cmake/packages/make.sh
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
source "$here/checks.sh"
archive=$(ls "$1"/tessera-*-linux-*.tar.gz)

mkdir "$work/some where" "$work/run"
tar -C "$work/some where" -xzf "$archive"
folder=$(echo "$work/some where"/tessera-*)
check_layout "$folder"
"$here/check_sbom.py" "${archive%.tar.gz}.spdx.json" "$folder"

newest=$(find "$folder/bin" "$folder/lib" -type f -exec readelf -V {} + 2>/dev/null | grep -o 'GLIBC_2\.[0-9]*' | sort -Vu | tail -1)
[[ $newest == GLIBC_2.36 ]] || fail "expected libraries for glibc 2.36, found some for $newest"

ln -s "$folder/bin/tessera" "$work/linked"
draws "$work/linked" "$work/run"

# Every module finds its libraries in the archive, but for those that the system may have.
while read -r library path; do
    case $path in
    "$folder"/*) ;;
    *) [[ -f $folder/lib/fallback/$library ]] || [[ $library =~ ^(ld-linux.*|lib(c|m|dl|rt|pthread|resolv))\.so ]] ||
        fail "$library is taken from $path" ;;
    esac
done < <(for module in "$folder"/lib/tessera/*.so; do
    LD_DEBUG=libs LD_PRELOAD="" env -i LD_TRACE_LOADED_OBJECTS=1 LD_PRELOAD="$module" "$folder/bin/tessera" 2>&1
done | sed -n 's/^\s*\(\S\+\) => \(.*\) (0x.*/\1 \2/p; s/^\s*\(\S\+\) => not found/\1 nowhere/p' | sort -u)
echo "archive: $(du -sm "$folder" | cut -f1) MB unpacked, $(($(stat -c %s "$archive") >> 20)) MiB packed"
