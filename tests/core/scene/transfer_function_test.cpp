// Transfer functions against a slow evaluator, bad points (unsorted, duplicate, not finite), and the table
// that GPU ray caster and mirror read.
#include "core/scene/transfer_function.h"

#include "core/base/error.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>

namespace tessera {
namespace {

/// Independent: the last pair of sorted points that brackets the value, found by walking.
double slowOpacity(const std::vector<OpacityPoint>& sorted, double v) {
    if (sorted.empty())
        return 0;
    if (v < sorted.front().value)
        return sorted.front().opacity;
    double result = sorted.back().opacity;
    for (std::size_t i = 0; i + 1 < sorted.size(); ++i) {
        const auto &a = sorted[i], &b = sorted[i + 1];
        if (v >= a.value && v < b.value)
            result = a.opacity + (b.opacity - a.opacity) * (v - a.value) / (b.value - a.value);
    }
    return v >= sorted.back().value ? sorted.back().opacity : result;
}

TEST(TransferFunction, ThousandRandomListsMatchSlowEvaluator) {
    std::mt19937 random(7);
    std::uniform_int_distribution<int> value(-20, 20), count(0, 12), level(-2, 12);
    for (int list = 0; list < 1000; ++list) {
        std::vector<OpacityPoint> points(static_cast<std::size_t>(count(random)));
        for (auto& p : points)
            p = {static_cast<double>(value(random)), level(random) / 10.0};
        const auto f = TransferFunction::fromOpacity(points, {}, 2.0);
        std::stable_sort(points.begin(), points.end(),
                         [](const auto& a, const auto& b) { return a.value < b.value; });
        for (auto& p : points)
            p.opacity = std::clamp(p.opacity, 0.0, 1.0);
        for (double v = -22; v <= 22; v += 0.25) {
            const double expected = -std::log1p(-std::min(slowOpacity(points, v), 1 - 0x1p-24)) / 2.0;
            ASSERT_NEAR(f.extinction(v), expected, 1e-12 * (1 + expected)) << "list " << list << " at " << v;
        }
    }
}

TEST(TransferFunction, StepTakesTheRightValueAndOutermostOfTriplicates) {
    const auto f = TransferFunction::fromExtinction({{0, 0}, {5, 0}, {5, 9}, {5, 2}, {10, 2}}, {});
    EXPECT_EQ(f.extinction(5), 2);
    EXPECT_EQ(f.extinction(std::nextafter(5.0, 0.0)), 0);
}

// Whatever the points are, readers of the table have numbers: a first value and a scale.
TEST(TransferFunction, TablesOfTheWidestFunctionsAreOfFiniteNumbers) {
    const double most = std::numeric_limits<float>::max();
    for (const double low : {-most, -1e30, 0.0, 1e-300, most})
        for (const double high : {-most, 5e-324, 1.0, 0.99 * most, most}) {
            const TransferFunction f = TransferFunction::fromOpacity({{low, 0}, {high, 1}}, {}, 1);
            for (const bool surface : {false, true}) {
                const TransferTable table = makeTable(f, surface ? std::vector<SurfaceValue>{{low}, {high}}
                                                                 : std::vector<SurfaceValue>());
                EXPECT_TRUE(std::isfinite(table.firstValue)) << low << " " << high;
                EXPECT_TRUE(std::isnormal(table.entriesPerValue)) << low << " " << high;
                for (const glm::vec4& entry : table.entries)
                    ASSERT_TRUE(std::isfinite(entry.a) && std::isfinite(entry.r)) << low << " " << high;
            }
        }
    EXPECT_THROW(TransferFunction::fromOpacity({{-1e308, 0}, {1e308, 1}}, {}, 1), InputError);
    EXPECT_THROW(TransferFunction::fromOpacity({}, {{3.5e38, {}}}, 1), InputError);
}

TEST(TransferFunction, RefusesWhatIsNotFinite) {
    const double nan = std::numeric_limits<double>::quiet_NaN(),
                 inf = std::numeric_limits<double>::infinity();
    EXPECT_THROW(TransferFunction::fromOpacity({{nan, 0}}, {}, 1), InputError);
    EXPECT_THROW(TransferFunction::fromOpacity({{0, inf}}, {}, 1), InputError);
    for (int c = 0; c < 3; ++c)
        for (const double bad : {nan, inf, -inf}) {
            glm::dvec3 colour(0.5);
            colour[c] = bad;
            EXPECT_THROW(TransferFunction::fromOpacity({{0, 0}}, {{0, colour}, {1, glm::dvec3(1)}}, 1),
                         InputError)
                << "component " << c;
        }
    EXPECT_THROW(TransferFunction::fromOpacity({{0, 0}}, {}, 0), InputError);
    EXPECT_THROW(TransferFunction::fromOpacity({{0, 0}}, {}, inf), InputError);
}

TEST(TransferFunction, OpacityOneIsFiniteAndNeverDependsOnAStep) {
    const auto f = TransferFunction::fromOpacity({{0, 1}}, {}, 0.5);
    EXPECT_NEAR(f.extinction(0), 24 * std::log(2.0) / 0.5, 1e-9);
}

TEST(TransferFunction, NoPointsIsTransparentWhite) {
    const TransferFunction f;
    EXPECT_EQ(f.extinction(3), 0);
    EXPECT_EQ(f.colour(3), glm::dvec3(1));
    EXPECT_TRUE(makeTable(f).emptyOver(-1e9, 1e9));
}

// The same walk, of lengths; unsorted, with steps and factors that are too large.
TEST(GradientOpacity, ThousandRandomListsMatchSlowEvaluator) {
    std::mt19937 random(11);
    std::uniform_int_distribution<int> length(0, 20), count(1, 12), level(-2, 12);
    for (int list = 0; list < 1000; ++list) {
        std::vector<GradientPoint> points(static_cast<std::size_t>(count(random)));
        for (auto& p : points)
            p = {static_cast<double>(length(random)), level(random) / 10.0};
        const auto g = GradientOpacity::fromPoints(points);
        std::vector<OpacityPoint> walked;
        for (const auto& p : points)
            walked.push_back({p.length, std::clamp(p.factor, 0.0, 1.0)});
        std::stable_sort(walked.begin(), walked.end(),
                         [](const auto& a, const auto& b) { return a.value < b.value; });
        for (double x = 0; x <= 22; x += 0.25) {
            ASSERT_NEAR(g.factor(x), slowOpacity(walked, x), 1e-12) << "list " << list << " at " << x;
            ASSERT_EQ(g.perMm(4).factor(x), g.factor(x)); // they are
        }
        const auto perVoxel = GradientOpacity::fromPoints(points, GradientOpacity::Per::voxel);
        for (double x = 0; x <= 22; x += 0.25)
            ASSERT_EQ(perVoxel.perMm(4).factor(x), g.factor(4 * x));
    }
}

TEST(GradientOpacity, OnesAreNoneAndLiesAreRefused) {
    EXPECT_TRUE(GradientOpacity().isOne());
    EXPECT_TRUE(GradientOpacity::fromPoints({{0, 1}, {50, 7}}).isOne());
    EXPECT_EQ(GradientOpacity::fromPoints({{0, 1}}, GradientOpacity::Per::voxel), GradientOpacity());
    EXPECT_EQ(GradientOpacity().factor(3), 1);
    const double nan = std::numeric_limits<double>::quiet_NaN(),
                 inf = std::numeric_limits<double>::infinity();
    for (const GradientPoint& p : {GradientPoint{nan, 0}, {inf, 0}, {-1, 0}, {1, nan}, {1, inf}})
        EXPECT_THROW(GradientOpacity::fromPoints({p}), InputError);
    EXPECT_NO_THROW(GradientOpacity::fromPoints(std::vector<GradientPoint>(16, {1, 0.5})));
    EXPECT_THROW(GradientOpacity::fromPoints(std::vector<GradientPoint>(17, {1, 0.5})), InputError);
}

TEST(TransferTable, SizeFollowsTheSharpestFeature) {
    const auto broad = makeTable(TransferFunction::fromExtinction({{0, 0}, {1000, 1}}, {}));
    const auto sharp =
        makeTable(TransferFunction::fromExtinction({{0, 0}, {499, 0}, {500, 1}, {501, 0}, {1000, 0}}, {}));
    EXPECT_EQ(broad.entries.size(), 256u);
    EXPECT_GE(sharp.entries.size(), 8000u);
    EXPECT_LT(sharp.relativeError, 0.13); // a bin is at most an eighth of the spike's flank
    EXPECT_LT(broad.relativeError, 1e-6);
}

// The function below the first of two points of one value differs from that above.
TEST(TransferTable, AStepAtTheFirstPointHasBothSides) {
    const auto table = makeTable(TransferFunction::fromExtinction({{0, 0}, {0, 1}, {10, 1}}, {}));
    EXPECT_EQ(table.entries.front().a, 0);
    EXPECT_EQ(table.entries[1].a, 1);
    EXPECT_TRUE(table.emptyOver(-5, -1));
    EXPECT_FALSE(table.emptyOver(0, 10));
}

// Surfaces show where the function shows nothing, and only there, at the lowest value of all too.
TEST(TransferTable, SurfacesAreNoEmptiness) {
    for (const bool withFunction : {false, true}) {
        const TransferFunction function =
            withFunction ? TransferFunction::fromExtinction({{100, 0}, {300, 0}}, {}) : TransferFunction();
        const TransferTable table = makeTable(function, {{.value = 200}, {.value = 100}});
        EXPECT_FALSE(table.emptyOver(90, 110));
        EXPECT_FALSE(table.emptyOver(195, 201));
        EXPECT_TRUE(table.emptyOver(120, 180));
        EXPECT_TRUE(table.emptyOver(-900, 50)) << "below all surfaces there is none";
        EXPECT_TRUE(table.emptyOver(250, 900));
        const TransferTable only = table.ofSurfaces();
        EXPECT_FALSE(only.emptyOver(90, 110));
        EXPECT_TRUE(only.emptyOver(120, 180));
    }
}

// Levels are predicted as if each isosurface were a step: from its value on an entry has the extinction of
// the densest one so far beside its own, and the colour of the last. Millimetres scale extinctions alone.
TEST(TransferTable, SurfacesAsStepsAreClosedForms) {
    const TransferFunction function =
        TransferFunction::fromExtinction({{0, 0.01}, {1000, 0.03}}, {{0, {0.2, 0.4, 0.6}}});
    const std::vector<SurfaceValue> surfaces = {{.value = 200, .colour = {1, 0, 0}, .opacity = 1},
                                                {.value = 500, .colour = {0, 1, 0}, .opacity = 0.5}};
    const TransferTable table = makeTable(function, surfaces);
    for (const double voxelMm : {0.5, 2.0}) {
        const TransferTable steps = table.withSurfacesAsSteps(voxelMm);
        const double dense = 0.5 / voxelMm, thin = 0.02 * 0.5 / voxelMm;
        for (std::size_t i = 0; i < table.entries.size(); ++i) {
            const double value = static_cast<double>(table.firstValue) +
                                 static_cast<double>(i) / static_cast<double>(table.entriesPerValue);
            const glm::vec4 own = table.entries[i], e = steps.entries[i];
            if (value < 200 - 1e-3) {
                ASSERT_EQ(e, own) << value;
                ASSERT_EQ(steps.shows(i), table.shows(i));
            } else if (value > 200 + 1e-3 && std::abs(value - 500) > 1e-3) {
                const double last = value < 500 ? dense : thin, all = own.a + last;
                ASSERT_NEAR(e.a, own.a + dense, 1e-6) << value; // the first hides more
                const double mine = own.a / all;
                ASSERT_NEAR(e.r, mine * own.r + (1 - mine) * (value < 500 ? 1 : 0), 1e-5) << value;
                ASSERT_NEAR(e.g, mine * own.g + (1 - mine) * (value < 500 ? 0 : 0.5), 1e-5) << value;
                ASSERT_TRUE(steps.shows(i));
            }
        }
    }
}

TEST(TransferTable, EmptinessRespectsGapsAndIsConservative) {
    const auto table = makeTable(TransferFunction::fromExtinction(
        {{-1000, 0}, {-500, 0}, {-400, 1}, {-300, 0}, {100, 0}, {200, 1}, {300, 1}}, {}));
    EXPECT_TRUE(table.emptyOver(-2000, -510));
    EXPECT_FALSE(table.emptyOver(-2000, -450));
    EXPECT_TRUE(table.emptyOver(-290, 90)); // the gap between two visible ranges
    EXPECT_FALSE(table.emptyOver(-310, 90));
    EXPECT_FALSE(table.emptyOver(400, 500)); // constant beyond the last point
    const auto extinctionOfTable = [&](double v) {
        const double x = std::clamp((v - static_cast<double>(table.firstValue)) *
                                        static_cast<double>(table.entriesPerValue),
                                    0.0, static_cast<double>(table.entries.size() - 1));
        const auto i = std::min(static_cast<std::size_t>(x), table.entries.size() - 2);
        const double f = x - static_cast<double>(i);
        return (1 - f) * static_cast<double>(table.entries[i].a) +
               f * static_cast<double>(table.entries[i + 1].a);
    };
    std::mt19937 random(3);
    std::uniform_real_distribution<double> at(-1200, 400);
    for (int trial = 0; trial < 2000; ++trial) {
        double a = at(random), b = at(random);
        if (a > b)
            std::swap(a, b);
        if (!table.emptyOver(a, b))
            continue;
        for (int i = 0; i <= 64; ++i)
            ASSERT_EQ(extinctionOfTable(a + (b - a) * i / 64), 0);
    }
}

// A step at one value has a table with room on either side: a unit, or a millionth of a large value.
TEST(TransferTable, OfASingleValueLiesAroundIt) {
    for (const double value : {0.0, -5.0, 300.0, 1e8, -3e9}) {
        const TransferTable table = makeTable(TransferFunction::fromExtinction({{value, 0}, {value, 1}}, {}));
        const double width = std::max(1.0, 1e-6 * std::abs(value)),
                     rounding = std::max(std::abs(value), 1.0) * 0x1p-23; // of the first value, a float
        EXPECT_NEAR(static_cast<double>(table.entries.size() - 1) /
                        static_cast<double>(table.entriesPerValue),
                    width, 1e-3 * width)
            << value;
        EXPECT_NEAR(static_cast<double>(table.firstValue), value - 0.5 * width, rounding) << value;
        EXPECT_EQ(table.entries.front().a, 0);
        EXPECT_EQ(table.entries.back().a, 1);
    }
}

} // namespace
} // namespace tessera
