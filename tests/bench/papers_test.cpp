// tests/bench/papers_test.cpp: the table of the papers' systems names what is there, and the lossy code of
// the comparison is one.
#include "core/base/brick.h"
#include "tests/bench/papers/dct_blocks.h"
#include "tests/bench/papers/papers.h"
#include "tests/support/folders.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>
#include <random>
#include <set>

namespace tessera::bench {
namespace {

TEST(PaperSystems, AreAllThereAndWhereTheTableSays) {
    std::set<std::string> ids;
    for (const PaperSystem& system : paperSystems()) {
        EXPECT_TRUE(ids.insert(system.id).second) << system.id << " stands twice";
        EXPECT_TRUE(std::filesystem::exists(test::sourceFolder() / system.where))
            << system.id << ": " << system.where;
        EXPECT_FALSE(std::string(system.status).empty()) << system.id;
        EXPECT_EQ(std::string(system.status).find("not yet"), std::string::npos) << system.id;
        const std::string page = system.measured;
        EXPECT_TRUE(page.empty() ||
                    std::filesystem::exists(test::sourceFolder() / "docs/measurements" / page))
            << system.id << ": " << page;
    }
    const auto expect = [&](const char* paper, int count) {
        for (int n = 1; n <= count; ++n)
            EXPECT_TRUE(ids.contains(paper + std::to_string(n))) << paper << n << " is missing";
    };
    expect("C", 63), expect("H", 8), expect("W", 8), expect("V", 11);
    EXPECT_EQ(ids.size(), 90u);
}

// A transform without loss but that of its steps: a coefficient is off by half a step at most, and the
// transform keeps lengths, so the rms is below that of steps at the highest frequency.
TEST(DctBlocks, AreOffByTheirStepsAtMost) {
    std::mt19937 random(5);
    std::uniform_int_distribution<int> noise(-1000, 1000);
    const std::size_t count = cellCount(glm::ivec3(kChunkExtent));
    std::vector<float> values(count), decoded(count);
    for (std::size_t n = 0; n < count; ++n)
        values[n] = static_cast<float>(noise(random));
    double before = 0;
    for (const double step : {0.5, 4.0, 32.0}) {
        decodeDct(encodeDct(values, step), step, decoded);
        double squares = 0;
        for (std::size_t n = 0; n < count; ++n)
            squares += std::pow(double{values[n]} - double{decoded[n]}, 2);
        const double rms = std::sqrt(squares / static_cast<double>(count));
        EXPECT_LT(rms, 0.5 * step * (1 + 0.5 * 21));
        EXPECT_GT(rms, before);
        before = rms;
    }
    // An even cube has one coefficient a block, and is exact where that is a whole number of steps.
    std::fill(values.begin(), values.end(), 100.0f);
    const auto coded = encodeDct(values, 1);
    EXPECT_LT(coded.size(), 200u);
    decodeDct(coded, 1, decoded);
    for (const float value : decoded)
        EXPECT_NEAR(value, 100.0f, 0.5f / std::sqrt(512.0f) + 1e-3f);
}

} // namespace
} // namespace tessera::bench
