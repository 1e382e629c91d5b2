#!/usr/bin/env bash
# Makes packages of a release build, in build/packages:
#   tessera_VERSION_ARCHITECTURE.deb, tessera-window_..., python3-tessera_... where Python's module is built
#   tessera-VERSION-linux-ARCHITECTURE.tar.gz  an archive that runs wherever it is unpacked, and its .spdx.json
#   SHA256SUMS
# The same commit on the same system gives the same bytes, in whichever folder.
#   make.sh [--fast] [deb] [archive]   --fast: packs quickly, into larger files; without names both are made
# BUILD_FOLDER: the build to take, in place of build/release, which is built first.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
source "$root/cmake/setup.sh"
here=$root/cmake/packages
level=9 parts=()
for word in "$@"; do
    case $word in
    --fast) level=1 ;;
    deb | archive) parts+=("$word") ;;
    *)
        echo "make.sh: expected --fast, deb or archive, found $word" >&2
        exit 2
        ;;
    esac
done
((${#parts[@]})) || parts=(deb archive)

build=${BUILD_FOLDER:-}
if [[ -z $build ]]; then
    ensure_packages "$root/cmake/debian-packages.txt" "$root/cmake/debian-packages-packages.txt"
    configure_release
    build=$root/build/release
    targets=(tessera)
    for part in "${parts[@]}"; do
        [[ $part == archive ]] && targets+=(tessera_relocatable)
    done
    if grep -q "^build tessera_python:" "$build/build.ninja"; then targets+=(tessera_python); fi
    build_release "${targets[@]}"
fi
build=$(realpath "$build")
# What is packed from here on is of the version's time, and of no place and user. (Objects are found in the compile cache by LC_ALL,
# too, and depend on none of these.)
SOURCE_DATE_EPOCH=$(date -d "$(sed -n 's/^ -- .*>  //p' "$here/debian/changelog" | head -1)" +%s)
export SOURCE_DATE_EPOCH LC_ALL=C TZ=UTC
umask 022
version=$(sed -n 's/^CMAKE_PROJECT_VERSION:STATIC=//p' "$build/CMakeCache.txt")
out=${OUT_FOLDER:-$root/build/packages}
mkdir -p "$out"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

make_archive() {
    local name folder
    name=tessera-$version-linux-$(uname -m)
    folder=$work/$name
    local component
    for component in program window; do
        cmake --install "$build" --prefix "$folder" --component "$component" --strip >/dev/null
    done
    install -m 755 "$build/relocatable/tessera" "$folder/bin/tessera"
    strip --strip-unneeded "$folder/bin/tessera" "$folder"/lib/tessera/*.so
    install -m 644 "$here/archive/README.txt" "$folder/README.txt"
    python3 "$here/bundle.py" "$folder"
    python3 "$here/sbom.py" "$folder" "$version" "$out/$name.spdx.json"
    chmod -R u=rwX,go=rX "$folder"
    tar -C "$work" --sort=name --mtime="@$SOURCE_DATE_EPOCH" --owner=0 --group=0 --numeric-owner --format=gnu -cf - "$name" |
        gzip -n "-$level" >"$out/$name.tar.gz"
}

make_deb() {
    (cd "$work" && cpack --config "$build/CPackConfig.cmake" -G DEB -B "$work/deb" \
        -D CPACK_DEBIAN_COMPRESSION_TYPE="$([[ $level == 1 ]] && echo gzip || echo xz)" >"$work/cpack.log") || {
        cat "$work/cpack.log" >&2
        return 1
    }
    mv "$work"/deb/*.deb "$out/"
}

for part in "${parts[@]}"; do
    "make_$part"
done
(cd "$out" && find . -maxdepth 1 -type f ! -name SHA256SUMS -printf '%f\n' | sort | xargs sha256sum >SHA256SUMS)
ls -l "$out" | awk 'NR > 1 { printf "%12d  %s\n", $5, $9 }'
