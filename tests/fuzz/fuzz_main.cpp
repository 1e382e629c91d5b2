// tests/fuzz/fuzz_main.cpp: what libFuzzer calls. FUZZED_READER names the reader; FUZZ_SEEDS=FOLDER writes
// its seeds there, and nothing is fuzzed.
#include "tests/fuzz/readers.h"

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>

namespace {

const tessera::test::FuzzedReader* reader = nullptr;

} // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
    const char* const name = std::getenv("FUZZED_READER");
    for (const tessera::test::FuzzedReader& each : tessera::test::fuzzedReaders())
        if (name && std::string(name) == each.name)
            reader = &each;
    if (!reader) {
        std::fprintf(stderr, "FUZZED_READER: expected one of");
        for (const tessera::test::FuzzedReader& each : tessera::test::fuzzedReaders())
            std::fprintf(stderr, " %s", each.name);
        std::fprintf(stderr, "\n");
        std::exit(2);
    }
    if (const char* const folder = std::getenv("FUZZ_SEEDS")) {
        int number = 0;
        for (const std::string& seed : reader->seeds())
            std::ofstream(std::string(folder) + "/seed" + std::to_string(number++), std::ios::binary) << seed;
        std::exit(0);
    }
    return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    reader->read(std::string(reinterpret_cast<const char*>(data), size));
    return 0;
}
