#!/bin/sh
# tests/interop/zarrita/run.sh SOURCE BUILD TEST: installs zarrita into BUILD (never into the source tree), lets TEST write its
# stores and raw copies there, and compares. Exit 77 (skipped) with the reason where node or the registry is missing.
set -eu
source=$1 build=$2 test=$3
skip() {
    echo "skipped: $1"
    exit 77
}
command -v node >/dev/null 2>&1 || skip "node is not installed"
command -v npm >/dev/null 2>&1 || skip "npm is not installed"
mkdir -p "$build"
cp "$source/package.json" "$source/check.mjs" "$build/"
cd "$build"
if [ ! -d node_modules/zarrita ]; then
    npm install --ignore-scripts --no-audit --no-fund --loglevel=error >npm.log 2>&1 ||
        skip "npm could not install zarrita: $(tail -n 1 npm.log)"
fi
rm -rf stores
mkdir stores
TESSERA_INTEROP_OUT="$build/stores" "$test" --gtest_filter='Interop.WriteStoresForZarrita'
node check.mjs stores
rm -rf stores
