#!/usr/bin/env bash
# Fuzzes readers of files by libFuzzer, with the address and the undefined behaviour sanitizer:
#   tests/fuzz/run.sh SECONDS [READER ...]     (all of them; the corpus grows in build/fuzz/corpus)
# What ends a run is kept in build/fuzz/found: mend it, and put the file into tests/fuzz/corpus/READER.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
cd "$root"
source cmake/setup.sh
seconds=$1
shift
cmake --preset asan -B build/fuzz -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_C_COMPILER=clang \
      -DTESSERA_SANITIZE=fuzzer-no-link,address,undefined -DTESSERA_WITH_FUZZERS=ON >/dev/null
cmake --build build/fuzz --target fuzz_readers
readers=("$@")
if [[ $# == 0 ]]; then
    mapfile -t readers < <(build/fuzz/fuzz_readers 2>&1 | tr ' ' '\n' | sed 1,4d)
fi
export ASAN_OPTIONS=detect_leaks=0:allocator_may_return_null=1 UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1
mkdir -p build/fuzz/found
for reader in "${readers[@]}"; do
    corpus=build/fuzz/corpus/$reader
    mkdir -p "$corpus"
    FUZZED_READER=$reader FUZZ_SEEDS=$corpus build/fuzz/fuzz_readers
    kept=tests/fuzz/corpus/$reader
    [[ -d $kept ]] && cp "$kept"/* "$corpus"
    echo "== $reader"
    FUZZED_READER=$reader build/fuzz/fuzz_readers -max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 \
        -malloc_limit_mb=512 -max_len=16384 -artifact_prefix="build/fuzz/found/$reader-" -print_final_stats=1 \
        -verbosity=0 "$corpus" 2>&1 | grep -avE "^INFO|NEW_FUNC|^stat::(new_units|slowest|average)" || true
done
ls build/fuzz/found
