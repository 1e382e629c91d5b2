// tests/fuzz/fuzz_test.cpp: every reader is given its seeds, simple damage of them, and what fuzzing found
// (corpus/READER/): it reads or refuses. run.sh fuzzes for longer.
#include "tests/fuzz/readers.h"
#include "tests/support/folders.h"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <random>

namespace tessera::test {
namespace {

class Fuzzed : public ::testing::TestWithParam<FuzzedReader> {};

std::string damaged(std::string bytes, std::mt19937& random) {
    const auto at = [&] { return bytes.empty() ? 0 : random() % bytes.size(); };
    for (auto changes = 1 + random() % 3; changes > 0; --changes)
        switch (random() % 6) {
        case 0:
            if (!bytes.empty())
                bytes[at()] = static_cast<char>(random());
            break;
        case 1:
            bytes.resize(at());
            break;
        case 2:
            bytes.insert(at(), 1 + random() % 9, static_cast<char>(random()));
            break;
        case 3: // a part twice
            bytes.insert(at(), bytes.substr(at(), random() % 40));
            break;
        case 4: // digits are sizes
            for (const std::size_t begin = at(); char& byte : bytes)
                if (&byte >= bytes.data() + begin && byte >= '0' && byte <= '9') {
                    byte = "0999-1e7"[random() % 8];
                    break;
                }
            break;
        default:
            bytes.erase(at(), random() % 9);
        }
    return bytes;
}

TEST_P(Fuzzed, ReadsOrRefuses) {
    const FuzzedReader& reader = GetParam();
    std::mt19937 random(1);
    int taken = 0;
    for (const std::string& seed : reader.seeds()) {
        taken += reader.read(seed);
        for (int i = 0; i < 100; ++i)
            reader.read(damaged(seed, random));
    }
    EXPECT_GT(taken, 0) << "no seed is good";
    const std::filesystem::path found = sourceFolder() / "tests/fuzz/corpus" / reader.name;
    std::error_code none;
    for (const auto& entry : std::filesystem::directory_iterator(found, none)) {
        SCOPED_TRACE(entry.path());
        std::ifstream file(entry.path(), std::ios::binary);
        reader.read({std::istreambuf_iterator<char>(file), {}});
    }
}

INSTANTIATE_TEST_SUITE_P(Readers, Fuzzed, ::testing::ValuesIn(fuzzedReaders()), [](const auto& info) {
    std::string name = info.param.name;
    std::erase(name, '-');
    return name;
});

} // namespace
} // namespace tessera::test
