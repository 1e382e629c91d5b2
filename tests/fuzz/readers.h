// tests/fuzz/readers.h: the readers of files that others wrote, as functions of bytes: what libFuzzer feeds
// (fuzz_main.cpp), and what a unit test feeds with seeds and simple damage (fuzz_test.cpp).
#pragma once

#include <string>
#include <vector>

namespace tessera::test {

struct FuzzedReader {
    const char* name;
    /// Reads a file of these bytes: true, or refuses them: false. Anything else is a fault.
    bool (*read)(const std::string& bytes);
    /// Small good files to begin with.
    std::vector<std::string> (*seeds)();
};

const std::vector<FuzzedReader>& fuzzedReaders();

} // namespace tessera::test
