#!/usr/bin/env bash
# The same commit makes the same bytes in another folder: program, modules, packages and archive. By hand, some minutes.
#   same_bytes.sh [OBJECT...]
# Objects come from the compile cache, which the folders share. Therefore some are compiled again in both, without it: those that
# are named, as ninja names them, else one of each kind of room; `all` compiles all, some ten minutes on a processor.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
cd "$root"
git diff --quiet HEAD || { echo "same_bytes.sh: expected a folder as committed, found changes"; exit 2; }
objects=("$@")
((${#objects[@]})) || objects=(core/CMakeFiles/tessera_base.dir/Unity/unity_0_cxx.cxx.o
    bricking/CMakeFiles/tessera_levels.dir/levels/level_error.cpp.o bricking/CMakeFiles/tessera_source.dir/Unity/unity_0_cxx.cxx.o
    render/CMakeFiles/tessera_gl.dir/Unity/unity_0_cxx.cxx.o viewer/CMakeFiles/tessera_command_pages.dir/Unity/unity_0_cxx.cxx.o
    viewer/CMakeFiles/tessera_window.dir/Unity/unity_0_cxx.cxx.o viewer/CMakeFiles/tessera_pictures.dir/cli/modules/picture_module.cpp.o)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
other=$work/a/folder/of/another/depth
mkdir -p "$work/one" "$work/two" "$(dirname "$other")"
git clone -q . "$other"
# The same options, of which none should change a byte, for the compile cache's sake.
strict=$(sed -n 's/^CMAKE_COMPILE_WARNING_AS_ERROR:[A-Z]*=//p' build/release/CMakeCache.txt 2>/dev/null || true)
(cd "$other" && cmake --preset release "-DCMAKE_COMPILE_WARNING_AS_ERROR=${strict:-OFF}" >/dev/null)

OUT_FOLDER=$work/one cmake/packages/make.sh --fast >/dev/null
(umask 077 && cd / && TZ=Asia/Tokyo OUT_FOLDER=$work/two "$other/cmake/packages/make.sh" --fast >/dev/null)
same() { # FILE FILE
    cmp "$1" "$2" || { echo "FAILED: $1 differs"; exit 1; }
    echo "same bytes: $1"
}
for file in build/release/tessera build/release/tessera_*.so; do same "$file" "$other/$file"; done
for file in "$work/one"/*; do same "$file" "$work/two/$(basename "$file")"; done

if [[ ${objects[0]} == all ]]; then
    mapfile -t objects < <(ninja -C build/release -t inputs tessera | grep '\.o$')
fi
export CCACHE_DISABLE=1
for object in "${objects[@]}"; do
    for folder in "$root" "$other"; do
        mv "$folder/build/release/$object" "$work/kept.$([[ $folder == "$root" ]] && echo one || echo two)"
        ninja -C "$folder/build/release" "$object" >/dev/null
    done
    same "build/release/$object" "$other/build/release/$object"
    cmp -s "build/release/$object" "$work/kept.one" || { echo "FAILED: the cache's $object differs"; exit 1; }
done
