// Crossings of a ray with surfaces of one value inside a trilinear cell. Cases: tangents, thin sheets, cells
// with two and three crossings, surfaces through samples, flat cells, extreme values.
#include "render/contract/cell_roots.h"

#include <array>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <vector>

namespace tessera {
namespace {

template <typename Real> std::vector<Real> rootsOf(Real v0, Real v1, Real v2, Real v3, Real isovalue = 0) {
    std::vector<Real> roots;
    const std::array<Real, 1> isovalues = {isovalue};
    forEachCrossing<Real>(v0, v1, v2, v3, isovalues, [&](Real u, std::size_t) { roots.push_back(u); });
    return roots;
}
template <typename Real> std::vector<Real> rootsOf(const std::function<Real(Real)>& f, Real isovalue = 0) {
    return rootsOf(f(0), f(Real(1) / 3), f(Real(2) / 3), f(1), isovalue);
}

template <typename Real> class CellRootsOf : public testing::Test {};
using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(CellRootsOf, Reals);

// (t-c)^2 - e: two roots sqrt(e) to either side, however small; (t-c)^2 + e: none.
TYPED_TEST(CellRootsOf, TangentsAreMetTwiceOrNotAtAll) {
    using Real = TypeParam;
    // The least distance that values of this precision tell from touching: they are rounded by 2^-24 or 2^-53
    // of the largest, the cubic through them by some thirty times that.
    const Real least = std::is_same_v<Real, double> ? Real(1e-12) : Real(1e-5);
    for (const Real e : {least, 10 * least, Real(1e-3)})
        for (int i = 1; i < 100; ++i) {
            const Real c = static_cast<Real>(i) / 100;
            if (c - std::sqrt(e) <= 0 || c + std::sqrt(e) >= 1)
                continue;
            for (const Real sign : {Real(1), Real(-1)}) {
                const auto two = rootsOf<Real>([&](Real t) { return sign * ((t - c) * (t - c) - e); });
                ASSERT_EQ(two.size(), 2u) << c << " " << e;
                // At the slope 2 sqrt(e), values off by d move the root by d / (2 sqrt(e)).
                const Real near = 40 * std::numeric_limits<Real>::epsilon() / std::sqrt(e);
                EXPECT_NEAR(two[0], c - std::sqrt(e), near);
                EXPECT_NEAR(two[1], c + std::sqrt(e), near);
                EXPECT_TRUE(rootsOf<Real>([&](Real t) { return sign * ((t - c) * (t - c) + e); }).empty());
            }
        }
}

// A surface through the end that two pieces share is hit once, in either direction. One that turns there is
// hit never or twice. A value is either below or not.
TYPED_TEST(CellRootsOf, SharedEndsAreMetOnce) {
    using Real = TypeParam;
    std::mt19937 random(4);
    std::uniform_real_distribution<Real> unit(-1, 1);
    for (int i = 0; i < 20000; ++i) {
        // Two lines that meet in a value that is exactly the surface's; ends of either sign.
        const Real isovalue = static_cast<Real>(i % 7 - 3);
        const Real before = isovalue + unit(random), after = isovalue + unit(random);
        const auto along = [](Real a, Real b, Real isovalue) {
            return rootsOf(a, a + (b - a) / 3, a + (b - a) * 2 / 3, b, isovalue).size();
        };
        const std::size_t met = along(before, isovalue, isovalue) + along(isovalue, after, isovalue);
        if ((before < isovalue) != (after < isovalue)) {
            ASSERT_EQ(met, 1u);
        } else {
            ASSERT_EQ(met, before < isovalue ? 2u : 0u);
        }
    }
}

TYPED_TEST(CellRootsOf, FlatAndExtremeValuesGiveNoFalseRoots) {
    using Real = TypeParam;
    for (const Real v : {Real(0), Real(1), Real(-1024), Real(1e30), std::numeric_limits<Real>::max(),
                         std::numeric_limits<Real>::denorm_min()}) {
        EXPECT_TRUE(rootsOf(v, v, v, v, v).empty());
        EXPECT_TRUE(rootsOf(v, v, v, v, Real(0.5)).empty());
    }
    for (const Real huge : {Real(1e30), Real(1e37)}) { // differences still are numbers
        const auto roots = rootsOf(-huge, -huge / 3, huge / 3, huge);
        ASSERT_EQ(roots.size(), 1u);
        EXPECT_NEAR(roots[0], 0.5, 1e-5);
        const auto two = rootsOf(huge, -huge, -huge, huge);
        EXPECT_EQ(two.size(), 2u);
    }
    // Whatever the values, infinite ones and no numbers included: roots are numbers in the piece.
    const Real infinity = std::numeric_limits<Real>::infinity();
    const std::array<Real, 9> values = {0,
                                        1,
                                        -1,
                                        std::numeric_limits<Real>::max(),
                                        infinity,
                                        -infinity,
                                        std::numeric_limits<Real>::quiet_NaN(),
                                        std::numeric_limits<Real>::denorm_min(),
                                        Real(-1e30)};
    for (const Real a : values)
        for (const Real b : values)
            for (const Real c : values)
                for (const Real d : values)
                    for (const Real isovalue : {Real(0), Real(0.5), Real(1e30)})
                        for (const Real u : rootsOf(a, b, c, d, isovalue)) {
                            ASSERT_GE(u, 0);
                            ASSERT_LE(u, 1);
                        }
}

/// A trilinear cell of random values and a ray through it, from face to face.
struct RandomCell {
    std::array<double, 8> v;
    glm::dvec3 from, to;
    explicit RandomCell(std::mt19937& random) {
        std::uniform_real_distribution<double> unit(-1, 1);
        for (double& value : v)
            value = unit(random);
        // A line through a random place in a random direction, cut at the faces.
        const glm::dvec3 p = glm::dvec3(unit(random), unit(random), unit(random)) * 0.5 + 0.5;
        glm::dvec3 d;
        do
            d = {unit(random), unit(random), unit(random)};
        while (glm::dot(d, d) > 1 || glm::dot(d, d) < 1e-4);
        double low = -1e9, high = 1e9;
        for (int axis = 0; axis < 3; ++axis) {
            const double a = -p[axis] / d[axis], b = (1 - p[axis]) / d[axis];
            low = std::max(low, std::min(a, b));
            high = std::min(high, std::max(a, b));
        }
        from = p + low * d;
        to = p + high * d;
    }
    double at(double u) const {
        const glm::dvec3 p = from + u * (to - from);
        double sum = 0;
        for (std::size_t n = 0; n < 8; ++n)
            sum += v[n] * ((n & 1) ? p.x : 1 - p.x) * ((n & 2) ? p.y : 1 - p.y) * ((n & 4) ? p.z : 1 - p.z);
        return sum;
    }
};

// Against a scan of 2000 places along the ray: as many crossings at the same places. Counts of the project's
// numerics: rays that meet the surface twice with both ends on one side (7.3 %), or three times (0.03 %).
TEST(CellRoots, RandomCellsAgainstAScan) {
    std::mt19937 random(12);
    constexpr int kCells = 40000, kPlaces = 2000;
    int hit = 0, twice = 0, thrice = 0, unlike = 0;
    double worst = 0;
    for (int i = 0; i < kCells; ++i) {
        const RandomCell cell(random);
        const auto roots = rootsOf(cell.at(0), cell.at(1.0 / 3), cell.at(2.0 / 3), cell.at(1));
        for (std::size_t r = 0; r < roots.size(); ++r) {
            worst = std::max(worst, std::abs(cell.at(roots[r])));
            ASSERT_TRUE(r == 0 || roots[r] >= roots[r - 1]);
        }
        std::vector<double> scanned;
        double before = cell.at(0);
        for (int k = 1; k <= kPlaces; ++k) {
            const double here = cell.at(static_cast<double>(k) / kPlaces);
            if ((before < 0) != (here < 0))
                scanned.push_back((k - 0.5) / kPlaces);
            before = here;
        }
        hit += roots.empty() ? 0 : 1;
        twice += roots.size() == 2 ? 1 : 0;
        thrice += roots.size() == 3 ? 1 : 0;
        if (roots.size() != scanned.size()) { // a scan misses two that lie between its places
            ++unlike;
            ASSERT_EQ(roots.size(), scanned.size() + 2);
        } else {
            for (std::size_t r = 0; r < roots.size(); ++r)
                ASSERT_NEAR(roots[r], scanned[r], 1.0 / kPlaces);
        }
    }
    EXPECT_LE(worst, 1e-13);
    EXPECT_LE(unlike, kCells / 2000);
    RecordProperty("twice", std::to_string(100.0 * twice / hit) + " %");
    RecordProperty("thrice", std::to_string(100.0 * thrice / hit) + " %");
    EXPECT_NEAR(100.0 * twice / hit, 7.3, 1.5);
    EXPECT_NEAR(100.0 * thrice / hit, 0.03, 0.03);
}

// In float, against double: the same count but where a crossing is lost in rounding, and places alike.
TEST(CellRoots, FloatsFindWhatDoublesFind) {
    std::mt19937 random(13);
    int unlike = 0;
    for (int i = 0; i < 100000; ++i) {
        const RandomCell cell(random);
        const std::array<double, 4> v = {cell.at(0), cell.at(1.0 / 3), cell.at(2.0 / 3), cell.at(1)};
        const auto fine = rootsOf(v[0], v[1], v[2], v[3]);
        const auto coarse = rootsOf(static_cast<float>(v[0]), static_cast<float>(v[1]),
                                    static_cast<float>(v[2]), static_cast<float>(v[3]));
        if (fine.size() != coarse.size()) {
            ++unlike;
            continue;
        }
        for (std::size_t r = 0; r < fine.size(); ++r)
            ASSERT_LE(std::abs(cell.at(static_cast<double>(coarse[r]))), 2e-6);
    }
    EXPECT_LE(unlike, 5);
}

// A sheet much thinner than a cell, and several surfaces: all met, in their order.
TEST(CellRoots, SurfacesComeInTheirOrder) {
    const std::array<double, 5> isovalues = {-0.5, 0.1, 0.1, 0.3, 0.9};
    std::mt19937 random(14);
    for (int i = 0; i < 20000; ++i) {
        const RandomCell cell(random);
        std::vector<std::pair<double, std::size_t>> met;
        std::array<std::size_t, 5> counts{}, alone{};
        forEachCrossing<double>(cell.at(0), cell.at(1.0 / 3), cell.at(2.0 / 3), cell.at(1), isovalues,
                                [&](double u, std::size_t s) {
                                    met.emplace_back(u, s);
                                    ++counts[s];
                                });
        for (std::size_t n = 1; n < met.size(); ++n)
            ASSERT_GE(met[n].first, met[n - 1].first - 1e-13);
        for (std::size_t s = 0; s < isovalues.size(); ++s)
            alone[s] =
                rootsOf(cell.at(0), cell.at(1.0 / 3), cell.at(2.0 / 3), cell.at(1), isovalues[s]).size();
        ASSERT_EQ(counts, alone);
    }
    // A bump that rises above the surface by a two-thousandth, over a fiftieth of the piece.
    const auto sheet = rootsOf<double>([](double t) { return 1.0005 - 4 * (t - 0.4) * (t - 0.4); }, 1.0);
    ASSERT_EQ(sheet.size(), 2u);
    EXPECT_NEAR(sheet[0], 0.4 - std::sqrt(0.0005 / 4), 1e-12);
    EXPECT_NEAR(sheet[1], 0.4 + std::sqrt(0.0005 / 4), 1e-12);
}

// The turns that a bracket takes at most, also where regula falsi alone would creep: the worst of u^3 and of
// steep ends.
TEST(CellRoots, AreCloseAfterTheirTurns) {
    for (const double isovalue : {1e-12, 1e-6, 1e-3, 0.5, 0.999, 1 - 1e-9}) {
        const CellCubic<double> cube{0, 0, 0, 1};
        EXPECT_NEAR(bracketedRoot(cube, isovalue, 0.0, 1.0, -isovalue, 1 - isovalue), std::cbrt(isovalue),
                    1e-15);
        const CellCubic<float> coarse{0, 0, 0, 1};
        EXPECT_NEAR(bracketedRoot(coarse, static_cast<float>(isovalue), 0.0f, 1.0f,
                                  -static_cast<float>(isovalue), 1 - static_cast<float>(isovalue)),
                    std::cbrt(isovalue), 3e-7);
    }
}

} // namespace
} // namespace tessera
