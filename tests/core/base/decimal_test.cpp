// tests/core/base/decimal_test.cpp: numbers are read as people write them, and other forms are none.
#include "core/base/decimal.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <gtest/gtest.h>
#include <random>
#include <string>

namespace tessera {
namespace {

TEST(Decimal, IsWhatAPrinterWrites) {
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> size(-12, 12);
    for (int n = 0; n < 3000; ++n) {
        const double number = std::pow(10, size(random)) * (random() % 2 == 0 ? 1 : -1);
        for (const char* form : {"%.17g", "%+.9g", "%.3f", "%E", "%.0f", " %g"}) {
            char text[80] = {};
            std::snprintf(text, sizeof text, form, number);
            ASSERT_TRUE(decimalNumber(text)) << text;
            EXPECT_EQ(*decimalNumber(text), std::strtod(text, nullptr)) << text;
            std::string comma(text);
            if (const std::size_t point = comma.find('.'); point != std::string::npos) {
                comma[point] = ',';
                EXPECT_FALSE(decimalNumber(comma)) << comma;
                EXPECT_TRUE(hasDecimalComma(comma)) << comma;
            }
            EXPECT_FALSE(hasDecimalComma(text)) << text;
        }
        char hex[80] = {};
        std::snprintf(hex, sizeof hex, "%a", number);
        EXPECT_FALSE(decimalNumber(hex)) << hex;
    }
    EXPECT_EQ(decimalNumber(".5"), 0.5);
    EXPECT_EQ(decimalNumber("5."), 5);
    EXPECT_EQ(decimalNumber("0"), 0);
    EXPECT_EQ(decimalNumber("-0.25"), -0.25);
    for (const char* none :
         {"",     " ",     "+",   "-",   ".",     "e5",        "0xFF", "-0X1", "0x",    "010",
          "-007", "00",    "nan", "NaN", "inf",   "-Infinity", "1,5",  "1 5",  "1.5.5", "5 ",
          "1e",   "1e400", "+-5", "--5", "1_000", "1'000",     "five", "5mm"})
        EXPECT_FALSE(decimalNumber(none)) << none;
    for (const char* none : {"", ",", "5,", ",x", "1,2,3", "1,5x", "40,-400"})
        EXPECT_FALSE(hasDecimalComma(none)) << none;
}

} // namespace
} // namespace tessera
