// tests/bricking/import/rounding_test.cpp: numbers that float32 cannot hold are told of with their largest
// change, against long doubles, however a volume is cut into rows; and nothing is told where none changed.
#include "bricking/import/source/slice_converter.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace tessera {
namespace {

using testing::ElementsAre;
using testing::EndsWith;
using testing::StartsWith;

template <class T> std::vector<std::byte> bytesOf(const std::vector<T>& values, bool bigEndian) {
    std::vector<std::byte> bytes(values.size() * sizeof(T));
    std::memcpy(bytes.data(), values.data(), bytes.size());
    for (std::size_t at = 0; bigEndian && at < bytes.size(); at += sizeof(T))
        std::reverse(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                     bytes.begin() + static_cast<std::ptrdiff_t>(at + sizeof(T)));
    return bytes;
}

/// Converts rows of random lengths.
template <class T>
VoxelTally tallyOf(const std::vector<T>& values, FileType type, bool bigEndian, double slope,
                   std::mt19937& random) {
    const std::vector<std::byte> in = bytesOf(values, bigEndian);
    std::vector<std::byte> out(values.size() * sizeof(float));
    SliceConverter converter(type, bigEndian, [](const auto&) {});
    VolumeInfo info;
    info.type = ValueType::f32;
    info.rescaleSlope = slope;
    VoxelTally tally;
    for (std::size_t first = 0; first < values.size();) {
        const std::size_t count = std::min(values.size() - first, 1 + random() % values.size());
        info.extentVoxels = {static_cast<int>(count), 1, 1};
        converter.convert(std::span(in).subspan(first * sizeof(T), count * sizeof(T)),
                          std::span(out).subspan(first * sizeof(float), count * sizeof(float)), info);
        if (random() % 2)
            tally.add(converter.takeTally());
        first += count;
    }
    tally.add(converter.takeTally());
    return tally;
}

template <class T> RoundingTally expectedOf(const std::vector<T>& values, double slope) {
    RoundingTally expected;
    for (const T value : values) {
        const long double exact = value, stored = static_cast<float>(value);
        if (exact == stored)
            continue;
        ++(std::is_integral_v<T> ? expected.whole : expected.real);
        expected.most =
            std::max(expected.most, static_cast<double>(std::abs(stored - exact)) * std::abs(slope));
        expected.mostPart =
            std::max(expected.mostPart, static_cast<double>(std::abs((stored - exact) / exact)));
    }
    return expected;
}

template <class T> void expectTold(FileType type, const std::function<T(std::mt19937&)>& value) {
    std::mt19937 random(11);
    for (const bool bigEndian : {false, true})
        for (const double slope : {1.0, -0.25}) {
            std::vector<T> values;
            for (int n = 0; n < 500; ++n)
                values.push_back(value(random));
            const RoundingTally expected = expectedOf(values, slope);
            ASSERT_TRUE(expected.any()) << name(type);
            EXPECT_TRUE(tallyOf(values, type, bigEndian, slope, random).rounded == expected) << name(type);
            for (T& each : values) // what float holds is kept
                if constexpr (std::is_integral_v<T>)
                    each %= 1 << 24;
                else
                    each = static_cast<double>(static_cast<float>(each));
            const VoxelTally none = tallyOf(values, type, bigEndian, slope, random);
            EXPECT_TRUE(none.rounded == RoundingTally()) << name(type);
            EXPECT_EQ(none.rounded.note(), "") << name(type);
        }
}

TEST(Rounding, IsToldWithTheLargestChange) {
    const auto bits = [](std::mt19937& random) { return (std::uint64_t{random()} << 32) | random(); };
    expectTold<std::int32_t>(FileType::i32, [](std::mt19937& r) { return static_cast<std::int32_t>(r()); });
    expectTold<std::uint32_t>(FileType::u32, [](std::mt19937& r) { return static_cast<std::uint32_t>(r()); });
    expectTold<std::int64_t>(FileType::i64,
                             [&](std::mt19937& r) { return static_cast<std::int64_t>(bits(r)); });
    expectTold<std::uint64_t>(FileType::u64, [&](std::mt19937& r) { return bits(r); });
    expectTold<double>(FileType::f64, [](std::mt19937& r) {
        return std::ldexp(static_cast<double>(r()) - 2147483648.0, static_cast<int>(r() % 100) - 60);
    });
}

TEST(Rounding, OfRealNumbersIsAShareOfThem) {
    std::mt19937 random(5);
    const auto noteOf = [&](const std::vector<double>& values) {
        return tallyOf(values, FileType::f64, false, 1, random).rounded.note();
    };
    EXPECT_EQ(noteOf({0.5, -1024, 3, 0, 0x1p120}), "");
    EXPECT_EQ(noteOf({0.1}),
              "values are kept as float32, which changed 1 of them: the largest change is 1.5e-09, "
              "1 in 2^26 of the value");
    EXPECT_THAT(noteOf({1000.123, 1000, 1 + std::ldexp(1, -24)}),
                StartsWith("values are kept as float32, which changed 2 of them: the largest change is "));
    EXPECT_THAT(noteOf({1 + std::ldexp(1, -24)}), EndsWith("6e-08, 1 in 2^24 of the value"));
    EXPECT_THAT(noteOf({1e-300}), EndsWith("the largest change is 1e-300")) << "all of it";
    const double none = std::nan("");
    EXPECT_EQ(noteOf({none, 1e300, -INFINITY, 5}), "") << "told as absent and clamped";
}

/// As NRRD's int and NIfTI's int64: labels may have become one.
TEST(Rounding, OfWholeNumbersIsToldOnce) {
    VoxelTally tally;
    tally.rounded = {3, 0, 2, 0x1p-24};
    tally.labels.isOther = true;
    EXPECT_THAT(tally.notes(),
                ElementsAre("3 whole numbers beyond 2^24 rounded to float32: labels may have become one; the "
                            "largest change is 2, 1 in 2^24 of the value"));
    EXPECT_THAT(VoxelTally().notes(), ElementsAre());
}

} // namespace
} // namespace tessera
