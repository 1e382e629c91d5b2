// tests/bricking/labels/label_values_test.cpp: numbers of every type as labels: the first and the last of
// each that is one, those beside them, and the voxel that a refusal names.
#include "bricking/import/labels/label_values.h"
#include "tests/support/import_test_tools.h"

#include <cmath>
#include <gmock/gmock.h>

namespace tessera::test {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;

/// The label of a number; nullopt where it is refused.
template <class T>
std::optional<std::uint32_t> labelOfNumber(FileType type, T number, double slope = 1, double intercept = 0) {
    for (const bool isBig : {true, false}) {
        LabelValues values(type, isBig, "f", {1, 1, 1});
        values.scale(slope, intercept);
        std::array<std::uint32_t, 1> out{77};
        try {
            const std::string bytes = voxelBytes<T>({number}, isBig);
            values.convert(std::as_bytes(std::span(bytes)), out);
            if (!isBig)
                return out[0];
        } catch (const InputError&) {
            if (!isBig)
                return std::nullopt;
        }
    }
    return std::nullopt;
}

TEST(LabelValues, WholeNumbersOfEveryType) {
    EXPECT_EQ(labelOfNumber<std::int8_t>(FileType::i8, 127), 127u);
    EXPECT_EQ(labelOfNumber<std::int8_t>(FileType::i8, -1), std::nullopt);
    EXPECT_EQ(labelOfNumber<std::uint8_t>(FileType::u8, 255), 255u);
    EXPECT_EQ(labelOfNumber<std::int16_t>(FileType::i16, 0x1234), 0x1234u);
    EXPECT_EQ(labelOfNumber<std::int16_t>(FileType::i16, -32768), std::nullopt);
    EXPECT_EQ(labelOfNumber<std::uint16_t>(FileType::u16, 0xFEDC), 0xFEDCu);
    EXPECT_EQ(labelOfNumber<std::int32_t>(FileType::i32, 0x12345678), 0x12345678u);
    EXPECT_EQ(labelOfNumber<std::int32_t>(FileType::i32, -1), std::nullopt);
    EXPECT_EQ(labelOfNumber<std::uint32_t>(FileType::u32, 0xFFFFFFFF), 0xFFFFFFFFu);
    EXPECT_EQ(labelOfNumber<std::int64_t>(FileType::i64, 0xFFFFFFFF), 0xFFFFFFFFu);
    EXPECT_EQ(labelOfNumber<std::int64_t>(FileType::i64, 0x100000000), std::nullopt);
    EXPECT_EQ(labelOfNumber<std::uint64_t>(FileType::u64, 0xFFFFFFFF), 0xFFFFFFFFu);
    EXPECT_EQ(labelOfNumber<std::uint64_t>(FileType::u64, ~std::uint64_t{0}), std::nullopt);
    EXPECT_EQ(labelOfNumber<float>(FileType::f32, 4294967040.f), 4294967040u);
    EXPECT_EQ(labelOfNumber<double>(FileType::f64, 4294967295.), 4294967295u);
    for (const double number : {4294967296., -1., 0.5, 1e300, -1e-300, std::nan(""), HUGE_VAL}) {
        EXPECT_EQ(labelOfNumber<double>(FileType::f64, number), std::nullopt) << number;
        if (std::abs(number) > 1e-30 || std::isnan(number)) { // the others are 0 as a float
            EXPECT_EQ(labelOfNumber<float>(FileType::f32, static_cast<float>(number)), std::nullopt)
                << number;
        }
    }
}

// A slope is a rounded number: values may be off by a hundred-thousandth of themselves, or of one.
TEST(LabelValues, ScaledNumbersAreNearWholeOnes) {
    EXPECT_EQ(labelOfNumber<std::int16_t>(FileType::i16, 3, 2, 5), 11u);
    EXPECT_EQ(labelOfNumber<std::int16_t>(FileType::i16, -3, -2, 5), 11u);
    EXPECT_EQ(labelOfNumber<std::int16_t>(FileType::i16, -3, 2, 5), std::nullopt);
    EXPECT_EQ(labelOfNumber<std::uint8_t>(FileType::u8, 3, 1, 5), 8u);
    EXPECT_EQ(labelOfNumber<std::uint8_t>(FileType::u8, 3, 2, 0), 6u);
    for (const double sign : {1., -1.}) {
        EXPECT_EQ(labelOfNumber<std::uint8_t>(FileType::u8, 0, 1, sign * 0.9e-5 + 1), 1u);
        EXPECT_EQ(labelOfNumber<std::uint8_t>(FileType::u8, 0, 1, sign * 1.1e-5 + 1), std::nullopt);
        EXPECT_EQ(labelOfNumber<std::uint8_t>(FileType::u8, 0, 1, sign * 0.9e-5), 0u);
        EXPECT_EQ(labelOfNumber<std::uint8_t>(FileType::u8, 0, 1, sign * 1.1e-5), std::nullopt);
        EXPECT_EQ(labelOfNumber<std::uint16_t>(FileType::u16, 10000, 1 + sign * 0.9e-5, 0), 10000u);
        EXPECT_EQ(labelOfNumber<std::uint16_t>(FileType::u16, 10000, 1 + sign * 1.1e-5, 0), std::nullopt);
    }
}

// Voxels are counted through portions of any length.
TEST(LabelValues, ARefusalNamesTheVoxel) {
    for (const std::size_t wrong : {0u, 4u, 5u, 29u, 30u, 77u, 119u}) { // of 5 x 6 x 4
        LabelValues values(FileType::i16, false, "f.nrrd", {5, 6, 4});
        std::vector<std::int16_t> numbers(120, 7);
        numbers[wrong] = -300;
        const std::string bytes = voxelBytes(numbers), at = std::to_string(wrong % 5) + ", " +
                                                            std::to_string(wrong / 5 % 6) + ", " +
                                                            std::to_string(wrong / 30);
        const std::string said = refusal([&] {
            for (std::size_t done = 0; done < 120;) {
                const std::size_t step = std::min<std::size_t>(7, 120 - done);
                std::vector<std::uint32_t> out(step);
                values.convert(std::as_bytes(std::span(bytes)).subspan(2 * done, 2 * step), out);
                done += step;
            }
        });
        EXPECT_EQ(said, "f.nrrd: expected labels: whole numbers from 0 to 4294967295, found -300 in voxel (" +
                            at + ")");
    }
}

} // namespace
} // namespace tessera::test
