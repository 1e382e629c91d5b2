// tests/core/scene/auto_function_test.cpp: the function that adapts to a volume's values, and tables of
// functions, against their definitions.
#include "core/base/error.h"
#include "core/image/colour.h"
#include "core/scene/mode.h"
#include "core/scene/preset.h"
#include "core/scene/scene_presets.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <random>
#include <string>

namespace tessera {
namespace {

/// Air in bin 0; of the object's 100 voxels one in each of bins 2 to 101 of 102: start, median and all but
/// its brightest are known.
ValueSummary even() {
    ValueSummary values{-51, 969, false, 2.5, std::vector<double>(102, 1)};
    values.histogram[0] = 1000, values.histogram[1] = 0;
    return values;
}

TEST(AutoFunction, RisesFromDarkRedToIvory) {
    const TransferFunction f = presetFunction("auto", even());
    EXPECT_EQ(f.referenceLengthMm(), 2.5);
    // bins of 10: the background ends with bin 0; bins 2 to 101 hold the object
    const double start = -41, middle = -31 + 500, top = -31 + 980;
    const std::vector<OpacityPoint> opacity = {
        {start, 0}, {(start + middle) / 2, 0.015}, {middle, 0.05}, {(middle + top) / 2, 0.2}, {top, 0.6}};
    ASSERT_EQ(f.opacityPoints().size(), opacity.size());
    for (std::size_t i = 0; i < opacity.size(); ++i) {
        EXPECT_NEAR(f.opacityPoints()[i].value, opacity[i].value, 1e-9) << i;
        EXPECT_EQ(f.opacityPoints()[i].opacity, opacity[i].opacity) << i;
    }
    const std::vector<ColourPoint> colour = {{start, {0.18, 0.03, 0.02}},
                                             {middle, {0.55, 0.20, 0.09}},
                                             {(middle + top) / 2, {0.80, 0.55, 0.32}},
                                             {top, {0.95, 0.90, 0.80}}};
    ASSERT_EQ(f.colourPoints().size(), colour.size());
    for (std::size_t i = 0; i < colour.size(); ++i) {
        EXPECT_NEAR(f.colourPoints()[i].value, colour[i].value, 1e-9) << i;
        EXPECT_EQ(f.colourPoints()[i].colour, colour[i].colour) << i;
    }
    EXPECT_NEAR(objectRange(even()).x, start, 1e-9);
    EXPECT_NEAR(objectRange(even()).y, top, 1e-9);
    EXPECT_EQ(objectRange({5, 5, false, 1, {}}).x, 5);
    EXPECT_GT(objectRange({5, 5, false, 1, {}}).y, 5);
}

/// Where the counts have fallen to a fiftieth of the peak, or rise by more than a quarter.
TEST(AutoFunction, BackgroundEndsAtItsFlankOrAtARise) {
    const auto start = [](std::vector<double> head) {
        ValueSummary values{0, 100, false, 1, std::move(head)};
        values.histogram.resize(100, 5);
        return objectRange(values).x;
    };
    EXPECT_DOUBLE_EQ(start({1000, 500, 100, 21, 20, 6}), 4) << "at the share exactly it has ended";
    EXPECT_DOUBLE_EQ(start({1000, 500, 100, 21, 20.1, 6}), 5);
    EXPECT_DOUBLE_EQ(start({1000, 500, 400, 500, 300, 1}), 5) << "a rise by a quarter is scatter";
    EXPECT_DOUBLE_EQ(start({1000, 500, 400, 501, 300, 1}), 3);
    EXPECT_DOUBLE_EQ(start({10, 20, 1000, 500, 1}), 4) << "from the largest peak on";
    // The peak is looked for in the lower half alone.
    ValueSummary values{0, 100, false, 1, std::vector<double>(10, 1)};
    values.histogram[1] = 50, values.histogram[5] = 900;
    EXPECT_DOUBLE_EQ(objectRange(values).x, 20);
    values.histogram[4] = 600;
    EXPECT_DOUBLE_EQ(objectRange(values).x, 50);
}

/// Values and the same with fill values beside them.
struct Filled {
    ValueSummary plain, filled;
};
Filled randomlyFilled(std::mt19937& random) {
    std::uniform_real_distribution<double> part(0, 1);
    Filled of;
    of.plain = {-100 * part(random), 10 + 1000 * part(random), false, 1 + part(random), {}};
    for (int bin = 0; bin < 64; ++bin)
        of.plain.histogram.push_back(std::floor(1000 * std::pow(part(random), 8)));
    of.plain.histogram.front() += 5000 * part(random), of.plain.histogram.back() += 1;
    of.filled = of.plain;
    const double range = of.plain.highest - of.plain.lowest;
    const int ends = 1 + static_cast<int>(random() % 3);
    const double share = 0.5 * part(random);
    if (ends & 1)
        of.filled.fills.push_back({of.plain.lowest - range * (1 + 1e6 * part(random)), share});
    if (ends & 2)
        of.filled.fills.push_back({of.plain.highest + range * (1 + 1e6 * part(random)), share});
    of.filled.measured = {of.plain.lowest, of.plain.highest, of.plain.histogram};
    for (const FillValue& fill : of.filled.fills) {
        of.filled.lowest = std::min(of.filled.lowest, fill.value);
        of.filled.highest = std::max(of.filled.highest, fill.value);
    }
    of.filled.histogram.assign(64, 0);
    of.filled.histogram[ends & 1 ? 63 : 0] = 12345; // the measurement in one bin, or nearly so
    return of;
}

/// Whatever fill values there are, the function is that of the measurement; above it nothing shows.
TEST(AutoFunction, FillValuesMoveNothing) {
    std::mt19937 random(7);
    for (int run = 0; run < 200; ++run) {
        const auto [plain, filled] = randomlyFilled(random);
        const TransferFunction f = presetFunction("auto", plain), g = presetFunction("auto", filled);
        EXPECT_EQ(g.referenceLengthMm(), f.referenceLengthMm());
        ASSERT_EQ(g.colourPoints().size(), f.colourPoints().size());
        for (std::size_t n = 0; n < f.colourPoints().size(); ++n)
            EXPECT_EQ(g.colourPoints()[n].value, f.colourPoints()[n].value);
        for (int n = 0; n <= 100; ++n) {
            const double value = plain.lowest + (plain.highest - plain.lowest) * n / 100;
            EXPECT_NEAR(g.extinction(value), f.extinction(value), 1e-12) << run;
        }
        for (const FillValue& fill : filled.fills) {
            EXPECT_EQ(g.extinction(fill.value), 0) << run;
            if (fill.value > plain.highest) { // between the measurement and its fill value
                EXPECT_EQ(g.extinction(0.9 * plain.highest + 0.1 * fill.value), 0) << run;
            }
        }
        EXPECT_EQ(objectRange(filled), objectRange(plain));
        EXPECT_EQ(windowOf("auto", filled, Mode::slice), windowOf("auto", plain, Mode::slice));
        for (const char* name : {"pet", "mr-brain"})
            EXPECT_EQ(presetFunction(name, filled).opacityPoints().front().value,
                      presetFunction(name, plain).opacityPoints().front().value);
        EXPECT_EQ(withoutFills(filled).histogram, plain.histogram);
        EXPECT_TRUE(withoutFills(filled).fills.empty());
    }
}

TEST(FillValues, AreToldWithTheirShares) {
    EXPECT_EQ(sayFills({}), "");
    EXPECT_EQ(sayFills({{-9999, 0.2134}}), "-9999, which 21 % of the voxels hold");
    EXPECT_EQ(
        sayFills({{-32768.5, 1e-7}, {1e20, 0.5}}),
        "-32768.5, which less than 0.001 % of the voxels hold and 1e+20, which 50 % of the voxels hold");
}

/// CT whose padding is far below air.
TEST(LooksLikeHu, PaddingIsLeftOut) {
    ValueSummary values{-1100, 5900, false, 1, std::vector<double>(70, 0)};
    values.histogram[1] = 30, values.histogram[20] = 70;
    ValueSummary padded{-32768, 5900, false, 1, std::vector<double>(64, 0)};
    padded.histogram[0] = 90, padded.histogram[63] = 10;
    EXPECT_FALSE(looksLikeHu(padded));
    padded.fills = {{-32768, 0.9}};
    padded.measured = {values.lowest, values.highest, values.histogram};
    EXPECT_TRUE(looksLikeHu(padded));
    padded.measured.histogram[1] = 0;
    EXPECT_FALSE(looksLikeHu(padded));
}

TEST(LooksLikeHu, SharesOfAirAndBodyAreMetExactly) {
    // bins of 100 from -1100 on: air is bins 0 to 2, which touch -1100 to -900
    ValueSummary values{-1100, 5900, false, 1, std::vector<double>(70, 0)};
    const auto looks = [&](double air, double body, double beyond) {
        values.histogram.assign(70, 0);
        values.histogram[1] = air, values.histogram[20] = body, values.histogram[60] = beyond;
        return looksLikeHu(values);
    };
    EXPECT_TRUE(looks(2, 98, 0));
    EXPECT_FALSE(looks(1.9, 98.1, 0));
    EXPECT_TRUE(looks(10, 65, 25));
    EXPECT_FALSE(looks(10, 64.9, 25.1));
    EXPECT_FALSE(looks(0, 0, 0));
}

TEST(PresetsOverRanges, EveryPlaceIsAShareOfTheRange) {
    Preset preset = builtInPreset("pet");
    const std::vector<OpacityPoint> shares = preset.function.opacityPoints();
    const std::vector<ColourPoint> colours = preset.function.colourPoints();
    preset.function.setGradientOpacity(GradientOpacity::fromPoints({{0.1, 0}, {0.5, 1}}));
    preset.function.setTissues({{0.25, 0.5, Phase{PhaseKind::rayleigh}, {}}});
    preset.function.setMaterials({{0.25, 0.5}});
    const Preset ranged = overRange(preset, 100, 300);
    EXPECT_EQ(ranged.function.tissues(), (std::vector<Tissue>{{150, 200, Phase{PhaseKind::rayleigh}, {}}}));
    EXPECT_EQ(ranged.function.materials(), (std::vector<Material>{{150, 200}}));
    EXPECT_EQ(ranged.unit, PresetUnit::any);
    ASSERT_EQ(ranged.function.opacityPoints().size(), shares.size());
    for (std::size_t i = 0; i < shares.size(); ++i) {
        EXPECT_DOUBLE_EQ(ranged.function.opacityPoints()[i].value, 100 + 200 * shares[i].value);
        EXPECT_EQ(ranged.function.opacityPoints()[i].opacity, shares[i].opacity);
    }
    ASSERT_EQ(ranged.function.colourPoints().size(), colours.size());
    for (std::size_t i = 0; i < colours.size(); ++i)
        EXPECT_DOUBLE_EQ(ranged.function.colourPoints()[i].value, 100 + 200 * colours[i].value);
    EXPECT_EQ(ranged.function.gradientOpacity(), GradientOpacity::fromPoints({{20, 0}, {100, 1}}));
    EXPECT_THROW(overRange(preset, 5, 5), InputError);
    EXPECT_THROW(overRange(preset, 5, INFINITY), InputError);
}

/// Empty ranges, by looking at every entry that values of the range can read.
TEST(Tables, AreEmptyWhereNoEntryIsSeen) {
    std::mt19937 random(4);
    std::uniform_real_distribution<double> place(-700, 700);
    for (int run = 0; run < 60; ++run) {
        std::vector<OpacityPoint> points;
        for (int i = 0; i < 6; ++i)
            points.push_back({place(random), i % 3 == 0 ? 0.3 : 0.0});
        const TransferTable table = makeTable(TransferFunction::fromOpacity(points, {}, 1));
        const auto last = static_cast<double>(table.entries.size() - 1);
        for (int i = 0; i < 60; ++i) {
            const double a = place(random), b = a + std::abs(place(random)) * (i % 5) / 40;
            const auto index = [&](double v) {
                return (v - static_cast<double>(table.firstValue)) *
                       static_cast<double>(table.entriesPerValue);
            };
            const auto held = [&](double at) { return static_cast<std::size_t>(std::clamp(at, 0.0, last)); };
            bool empty = true, surely = true;
            for (std::size_t n = held(std::floor(index(a))); n <= held(std::ceil(index(b))); ++n)
                empty = empty && table.entries[n].a == 0;
            for (std::size_t n = held(std::floor(index(a)) - 1); n <= held(std::ceil(index(b)) + 1); ++n)
                surely = surely && table.entries[n].a == 0;
            EXPECT_EQ(table.emptyOver(a, b), surely);
            EXPECT_TRUE(empty || !table.emptyOver(a, b));
        }
    }
}

TEST(Tables, BeginAtTheFirstPointAndEndAtTheLast) {
    const TransferTable table = makeTable(
        TransferFunction::fromExtinction({{-200, 1}, {300, 6}}, {{-200, {1, 0, 0}}, {300, {0, 1, 0}}}));
    EXPECT_EQ(table.firstValue, -200);
    const std::size_t last = table.entries.size() - 1;
    EXPECT_NEAR(table.entriesPerValue, static_cast<double>(last) / 500, 1e-6);
    for (std::size_t i = 0; i <= last; ++i) {
        const double part = static_cast<double>(i) / static_cast<double>(last);
        EXPECT_NEAR(table.entries[i].a, 1 + 5 * part, 1e-5);
        EXPECT_NEAR(table.entries[i].g, part, 1e-5);
        EXPECT_EQ(table.nonZeroUpTo[i], static_cast<int>(i) + 1);
    }
    EXPECT_NEAR(table.relativeError, 0, 1e-6);
}

TEST(Tables, OfValuesAreGreyAndKeepTheEndThatIsNoValue) {
    ValueLook look;
    look.window = {40, 400};
    for (const ValueColour colour : {ValueColour::window, ValueColour::inverse}) {
        look.colour = colour;
        for (const Reduction reduction : {Reduction::maximum, Reduction::minimum, Reduction::average}) {
            const TransferTable table = valueTable(look, {}, reduction);
            EXPECT_EQ(table.firstValue, -160);
            const std::size_t last = table.entries.size() - 1;
            EXPECT_NEAR(table.entriesPerValue, static_cast<double>(last) / 400, 1e-6);
            EXPECT_EQ(table.entries[0].a, reduction == Reduction::maximum ? 0 : 1);
            EXPECT_EQ(table.entries[last].a, reduction == Reduction::minimum ? 0 : 1);
            for (std::size_t i = 0; i <= last; i += 39) {
                const double value = -160 + 400.0 * static_cast<double>(i) / static_cast<double>(last);
                const glm::dvec3 shown = colourOfValue(look, {}, value);
                EXPECT_LT(glm::length(glm::dvec3(table.entries[i]) - shown), 1e-5) << i;
                const double part = static_cast<double>(i) / static_cast<double>(last);
                EXPECT_NEAR(srgbFromLinear(shown.g), colour == ValueColour::inverse ? 1 - part : part, 1e-6);
                if (i > 0 && i < last) {
                    EXPECT_EQ(table.entries[i].a, 1);
                }
            }
            EXPECT_EQ(table.nonZeroUpTo[last],
                      static_cast<int>(last) + (reduction == Reduction::average ? 1 : 0));
        }
    }
    EXPECT_EQ(ColourPoint{}.value + OpacityPoint{}.value + OpacityPoint{}.opacity, 0);
}

} // namespace
} // namespace tessera
