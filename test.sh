#!/usr/bin/env bash
# Builds everything and runs all tests; arguments go to ctest, e.g. ./test.sh -L unit -R Scene
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
source "$root/cmake/setup.sh"

ensure_packages "$root/cmake/debian-packages.txt" "$root/cmake/debian-packages-tests.txt"
configure_release TESTS
build_release
cd "$root"
exec ctest --preset release -j2 --output-on-failure "$@"
