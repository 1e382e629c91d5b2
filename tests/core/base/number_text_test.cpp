// Numbers as people read them: every digit before the point, no padding, powers of ten only where they help.
#include "core/base/shown_text.h"

#include <cmath>
#include <cstdlib>
#include <gtest/gtest.h>

namespace tessera {
namespace {

TEST(NumberText, WritesEveryDigitBeforeThePoint) {
    EXPECT_EQ(numberText(10012), "10012");
    EXPECT_EQ(numberText(-1024.4), "-1024");
    EXPECT_EQ(numberText(9999.6), "10000");
    EXPECT_EQ(numberText(1.07), "1.07");
    EXPECT_EQ(numberText(1.0), "1");
    EXPECT_EQ(numberText(0.0), "0");
    EXPECT_EQ(numberText(0.00012347), "0.0001235");
    EXPECT_EQ(numberText(2.5e-7), "2.5e-07");
    EXPECT_EQ(numberText(123456, 2), "123456");
    for (double value = 1; value < 1e15; value *= 7.3) {
        const std::string text = numberText(value);
        EXPECT_EQ(text.find('e'), std::string::npos) << text;
        EXPECT_NEAR(std::strtod(text.c_str(), nullptr), value, value * 5e-4) << text;
    }
}

TEST(NumberText, LengthsAreInTenths) {
    EXPECT_EQ(mmText(1.863e-18), "0 mm");
    EXPECT_EQ(mmText(-0.01), "0 mm");
    EXPECT_EQ(mmText(7.219), "7.2 mm");
    EXPECT_EQ(mmText(1204.52), "1204.5 mm");
}

} // namespace
} // namespace tessera
