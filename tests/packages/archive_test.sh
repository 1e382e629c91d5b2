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

# Every module finds its libraries in the archive, but for those that the system may have. (The loader takes no blank.)
ln -s "$folder" "$work/plain"
modules=0
for module in "$work"/plain/lib/tessera/*.so; do
    env -i LD_TRACE_LOADED_OBJECTS=1 LD_PRELOAD="$module" "$folder/bin/tessera" >"$work/loaded"
    grep -qF "$module" "$work/loaded" || fail "$module was not loaded"
    while read -r library path; do
        case $path in
        "$folder"/* | "$work"/plain/*) ;;
        *) [[ -f $folder/lib/fallback/$library ]] || [[ $library =~ ^lib(c|m|dl|rt|pthread|resolv)\.so ]] ||
            fail "$(basename "$module"): $library is taken from $path" ;;
        esac
    done < <(sed -n 's/^\s*\(\S\+\) => not found/\1 nowhere/p; s/^\s*\(\S\+\) => \(.*\) (0x.*/\1 \2/p' "$work/loaded")
    modules=$((modules + 1))
done
((modules > 5)) || fail "expected modules, found $modules"
echo "archive: $(du -sm "$folder" | cut -f1) MB unpacked, $(($(stat -c %s "$archive") >> 20)) MiB packed"
