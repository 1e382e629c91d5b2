// tests/render/backends/splat/value_lists_test.cpp: samples by value are those that classification finds.
#include "render/backends/splat/value_lists.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <random>

namespace tessera::test {
namespace {

TEST(ValueLists, HoldWhatClassificationFinds) {
    std::mt19937 random(5);
    std::normal_distribution<float> value(100, 300);
    std::vector<float> values(32 * 32 * 32);
    for (float& v : values)
        v = std::clamp(value(random), -1000.0f, 1500.0f);
    const ValueLists lists(values, -1000, 1500);
    EXPECT_EQ(lists.bytes(), 3u * 32 * 1024 * 2 + 3u * 32 * 257 * 2); // 3.7 times the values of 16 bits
    const Intervals shown = {{0, 3}, {100, 120}, {255, 256}};
    const auto shows = [&](float v) {
        const int n = ValueLists::intervalOf(v, -1000, 1500);
        return std::any_of(shown.begin(), shown.end(),
                           [n](const auto& i) { return n >= i.first && n < i.second; });
    };
    std::size_t found = 0;
    for (int axis = 0; axis < 3; ++axis)
        for (int slice = 0; slice < 32; ++slice) {
            std::vector<std::uint16_t> collected, classified;
            lists.collect(axis, slice, shown, collected);
            for (int place = 0; place < 1024; ++place) {
                int at[3];
                at[axis] = slice;
                at[axis == 0 ? 1 : 0] = place % 32;
                at[axis == 2 ? 1 : 2] = place / 32;
                if (shows(values[static_cast<std::size_t>(at[0] + 32 * (at[1] + 32 * at[2]))]))
                    classified.push_back(static_cast<std::uint16_t>(place));
            }
            std::sort(collected.begin(), collected.end());
            EXPECT_EQ(collected, classified) << axis << " " << slice;
            found += collected.size();
        }
    EXPECT_GT(found, 3000u);
}

TEST(ValueLists, EndsOfTheRangeAreIntervals) {
    EXPECT_EQ(ValueLists::intervalOf(-2000, -1000, 1500), 0);
    EXPECT_EQ(ValueLists::intervalOf(1500, -1000, 1500), 255);
    EXPECT_EQ(ValueLists::intervalOf(9e9f, -1000, 1500), 255);
}

} // namespace
} // namespace tessera::test
