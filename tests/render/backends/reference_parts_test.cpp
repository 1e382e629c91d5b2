// tests/render/backends/reference_parts_test.cpp: parts of the reference against brute force: cubics and
// their crossings, planes along rays, functions over stored values, light between points, the work of panels.
#include "render/backends/reference/cells_on_ray.h"
#include "render/backends/reference/left_by_others.h"
#include "render/backends/reference/light_between.h"
#include "render/backends/reference/reference_integrator.h"
#include "render/backends/reference/stored_function.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace tessera {
namespace {

/// Cubics that rise, fall, turn once and twice, and are of a lower degree.
std::vector<Cubic> someCubics() {
    std::mt19937 random(21);
    std::uniform_real_distribution<double> value(-1, 1);
    std::vector<Cubic> cubics = {{1, 1, 1, 1}, {0, 1, 2, 3}, {3, 2, 1, 0}, {0, 1, 1, 0}, {1, -1, 1, -1}};
    for (int n = 0; n < 300; ++n)
        cubics.emplace_back(value(random), value(random), value(random), value(random));
    return cubics;
}

TEST(CubicsOnRays, GoThroughTheirValuesAndTurnWhereTheirSlopeIsNone) {
    const std::array<double, 4> given = {0.3, -1.25, 2, 0.75};
    const Cubic f(given[0], given[1], given[2], given[3]);
    for (int n = 0; n < 4; ++n)
        EXPECT_NEAR(f(n / 3.0), given[static_cast<std::size_t>(n)], 1e-13);
    std::size_t pieces = 0;
    for (const Cubic& cubic : someCubics()) {
        for (double u = 0.05; u < 1; u += 0.1)
            EXPECT_NEAR(cubic.slope(u), (cubic(u + 1e-5) - cubic(u - 1e-5)) / 2e-5, 1e-6);
        std::array<double, 4> ends{};
        const std::size_t count = cubic.monotonePieces(ends);
        ASSERT_GE(count, 2u);
        EXPECT_EQ(ends[0], 0);
        EXPECT_EQ(ends[count - 1], 1);
        for (std::size_t i = 0; i + 1 < count; ++i) {
            ASSERT_LT(ends[i], ends[i + 1]);
            const double rise = cubic(ends[i + 1]) - cubic(ends[i]);
            double before = cubic(ends[i]);
            for (int n = 1; n <= 50; ++n) { // monotone
                const double now = cubic(ends[i] + (ends[i + 1] - ends[i]) * n / 50);
                EXPECT_GE((now - before) * (rise > 0 ? 1 : -1), -1e-12);
                before = now;
            }
            if (i > 0) {
                EXPECT_NEAR(cubic.slope(ends[i]), 0, 1e-7);
            }
            const double sought = cubic(ends[i]) + 0.3 * rise;
            if (std::abs(rise) > 1e-3) {
                EXPECT_NEAR(cubic(crossing(cubic, sought, ends[i], ends[i + 1])), sought, 1e-12);
            }
        }
        pieces += count - 1;
    }
    EXPECT_GT(pieces, 400u) << "some turn";
}

TEST(CubicsOnRays, CrossSurfacesInTheirOrder) {
    const std::vector<Isosurface> surfaces = {{-0.5}, {-0.1}, {0.2}, {0.2}, {0.6}};
    for (const Cubic& cubic : someCubics()) {
        const CellStretch stretch(cubic(0.0), cubic(1.0 / 3), cubic(2.0 / 3), cubic(1.0));
        std::vector<std::pair<double, std::size_t>> met;
        EXPECT_FALSE(crossSurfaces(stretch, surfaces, [&](double u, std::size_t number) {
            met.emplace_back(u, number);
            return false;
        }));
        EXPECT_TRUE(std::is_sorted(met.begin(), met.end(),
                                   [](const auto& a, const auto& b) { return a.first < b.first - 1e-12; }));
        for (std::size_t n = 0; n < surfaces.size(); ++n) {
            int changes = 0; // of the side, on a fine grid
            for (int k = 0; k < 4000; ++k)
                changes +=
                    (cubic(k / 4000.0) < surfaces[n].value) != (cubic((k + 1) / 4000.0) < surfaces[n].value);
            int found = 0;
            for (const auto& [u, number] : met)
                if (number == n) {
                    ++found;
                    EXPECT_NEAR(cubic(u), surfaces[n].value, 1e-12);
                }
            EXPECT_TRUE(found == changes || found == changes + 2) << "a grid may step over two";
        }
        if (!met.empty()) { // it stops where it is told to
            std::size_t visits = 0;
            EXPECT_TRUE(crossSurfaces(stretch, surfaces, [&](double, std::size_t) { return ++visits == 1; }));
            EXPECT_EQ(visits, 1u);
        }
    }
    // Two of one value: by their numbers where the field rises, the other way round where it falls.
    std::vector<std::size_t> order;
    const auto visit = [&](double, std::size_t number) {
        order.push_back(number);
        return false;
    };
    crossSurfaces(CellStretch(0, 1, 2, 3), {{1}, {1}, {2}}, visit);
    EXPECT_EQ(order, (std::vector<std::size_t>{0, 1, 2}));
    order.clear();
    crossSurfaces(CellStretch(3, 2, 1, 0), {{1}, {1}, {2}}, visit);
    EXPECT_EQ(order, (std::vector<std::size_t>{2, 1, 0}));
    // A value that an end has: below is one side, the value itself the other.
    order.clear();
    crossSurfaces(CellStretch(1, 2, 3, 4), {{1}, {4}}, visit);
    EXPECT_EQ(order, std::vector<std::size_t>{1});
}

// Planes of three axes, by all their crossings in a list.
TEST(IntervalsOnRays, EndAtEveryPlane) {
    std::mt19937 random(22);
    std::uniform_real_distribution<double> place(-4, 9), slope(-2, 2);
    for (int n = 0; n < 400; ++n) {
        ReferenceRay ray;
        ray.base = {place(random), place(random), place(random)};
        ray.direction = {slope(random), n % 3 == 0 ? 0 : slope(random), n % 5 == 0 ? 0 : slope(random)};
        if (n % 7 == 0)
            ray.base.x = 2.5; // on a plane
        const double spacing = n % 2 ? 1 : 0.5, offset = n % 4 < 2 ? 0.5 : 0, t0 = 0.25 * (n % 3), t1 = 5.3;
        std::vector<double> expected = {t0, t1};
        for (int axis = 0; axis < 3; ++axis)
            for (int k = -60; k <= 60; ++k)
                if (ray.direction[axis] != 0) {
                    const double t = (offset + k * spacing - ray.base[axis]) / ray.direction[axis];
                    if (t > t0 && t < t1)
                        expected.push_back(t);
                }
        std::sort(expected.begin(), expected.end());
        std::vector<double> found;
        double before = t0;
        forEachInterval(ray, t0, t1, spacing, offset, [&](double a, double b) {
            EXPECT_EQ(a, before) << "no gap";
            EXPECT_LT(a, b);
            found.push_back(a);
            before = b;
        });
        EXPECT_EQ(before, t1);
        found.push_back(before);
        ASSERT_EQ(found.size(), expected.size()) << n;
        for (std::size_t i = 0; i < found.size(); ++i)
            EXPECT_NEAR(found[i], expected[i], 1e-9) << n;
    }
    int visits = 0;
    forEachInterval({{0, 0, 0}, {0, 0, 0}}, 1, 2, 1, 0, [&](double a, double b) {
        EXPECT_EQ(a, 1);
        EXPECT_EQ(b, 2);
        ++visits;
    });
    EXPECT_EQ(visits, 1) << "no plane is crossed";
    forEachInterval({{0, 0, 0}, {1, 0, 0}}, 2, 2, 1, 0, [&](double, double) { ++visits; });
    EXPECT_EQ(visits, 1) << "nothing to go through";
}

// Steps, gaps and slopes over stored values that fall as physical ones rise, against the function itself.
TEST(StoredFunctions, AreTheFunctionOfThePhysicalValue) {
    TransferFunction function = TransferFunction::fromOpacity(
        {{-100, 0}, {-50, 0.4}, {-50, 0.1}, {0, 0}, {60, 0}, {60, 0.3}, {90, 0.3}, {120, 0}},
        {{-80, {1, 0, 0.5}}, {20, {0, 1, 0.25}}, {20, {0.5, 0.5, 0.5}}, {100, {1, 1, 0}}}, 1.5);
    function.setMaterials({{-60, 10, 0.1, 0.2, 0.3, 4, {1, 2, 3}}, {70, 80, 0.5, 0.6, 0.7, 8, {4, 5, 6}}});
    VolumeInfo info;
    info.rescaleSlope = -2;
    info.rescaleIntercept = 10;
    const StoredFunction stored(function, {{70, {}, 0.5}, {30, {}, 0}, {-20, {}, 1}}, info);
    const auto storedOf = [](double value) { return (value - 10) / -2; };
    ASSERT_EQ(stored.surfaces().size(), 2u) << "without that which is not seen";
    EXPECT_EQ(stored.surfaces()[0].value, -30);
    EXPECT_EQ(stored.surfaces()[1].value, 15);
    EXPECT_TRUE(std::is_sorted(stored.kinks().begin(), stored.kinks().end()));
    for (const double kink :
         {-100.0, -50.0, 0.0, 60.0, 90.0, 120.0, -80.0, 20.0, 100.0, -60.0, 10.0, 70.0, 80.0})
        EXPECT_TRUE(std::binary_search(stored.kinks().begin(), stored.kinks().end(), storedOf(kink))) << kink;
    Optics optics;
    optics.phong = {0.9, 0.8, 0.7};
    optics.specularPower = 6;
    for (double value = -130; value <= 140; value += 0.5) {
        const double s = storedOf(value);
        EXPECT_NEAR(stored.extinction(s), function.extinction(value), 1e-12) << value;
        const leaf::Material<double> material = stored.materialAt(s, optics);
        const int which = value >= -60 && value < 10 ? 1 : value >= 70 && value < 80 ? 2 : 0;
        EXPECT_FLOAT_EQ(static_cast<float>(material.ambient), which == 1 ? 0.1f : which == 2 ? 0.5f : 0.9f);
        EXPECT_FLOAT_EQ(static_cast<float>(material.diffuse), which == 1 ? 0.2f : which == 2 ? 0.6f : 0.8f);
        EXPECT_FLOAT_EQ(static_cast<float>(material.specular), which == 1 ? 0.3f : which == 2 ? 0.7f : 0.7f);
        EXPECT_EQ(material.power, which == 1 ? 4 : which == 2 ? 8 : 6);
        EXPECT_EQ(stored.emission(s), which == 1   ? glm::dvec3(1, 2, 3)
                                      : which == 2 ? glm::dvec3(4, 5, 6)
                                                   : glm::dvec3(0))
            << value;
        if (std::binary_search(stored.kinks().begin(), stored.kinks().end(), s))
            continue; // pieces are between points
        const FunctionPiece piece = stored.pieceAround(s);
        EXPECT_NEAR(piece.value(s), value, 1e-12);
        EXPECT_NEAR(piece.extinctionAt(value), function.extinction(value), 1e-12) << value;
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(piece.colourAt(value, c), function.colour(value)[c], 1e-12) << value;
        const bool even = value < -100 || (value > 0 && value < 90) || value > 120;
        EXPECT_EQ(piece.hasOneExtinction(), even) << value;
        EXPECT_EQ(piece.isTransparent(), value < -100 || (value > 0 && value < 60) || value > 120) << value;
        if (even) {
            EXPECT_NEAR(piece.extinction(), function.extinction(value), 1e-12);
        }
    }
    // What a range of values shows, by many of its values; bounds at points, at surfaces and beside them.
    for (const double a : {-130.0, -100.0, -99.0, -50.0, -19.0, 1.0, 31.0, 59.0, 60.0, 121.0, 125.0})
        for (const double wide : {0.0, 0.5, 8.0, 29.0, 50.0, 200.0}) {
            const double b = a + wide;
            bool surface = false, shows = false;
            for (const double value : {70.0, -20.0})
                surface = surface || (a <= value && value <= b);
            double most = 0;
            for (int n = 0; n <= 4000; ++n)
                most = std::max(most, function.extinction(a + wide * n / 4000));
            for (const double point : {-50.0, 60.0}) // both limits of a step count
                if (a <= point && point <= b)
                    most = std::max({most, function.extinction(point),
                                     a < point ? function.extinction(std::nextafter(point, -1e9)) : 0.0});
            shows = most > 0;
            const double low = storedOf(b), high = storedOf(a);
            EXPECT_EQ(stored.emptyOver(low, high), !surface && !shows) << a << " " << b;
            if (wide > 0) {
                EXPECT_GE(stored.mostExtinction(low, high), most - 1e-12) << a << " " << b;
            }
        }
    EXPECT_TRUE(StoredFunction(TransferFunction::fromExtinction({}, {}), {}, info).emptyOver(-9, 9));
}

// An even medium, and one that ends: depths, shares and integrals are those of their formulas.
TEST(LeftByOthersOnRays, IsTheLightOfItsFormulas) {
    const double mm = 12.8, k = 0.35;
    const LeftByOthers even(mm, [&](double from, double to) { return std::exp(-k * (to - from)); });
    for (const double at : {0.0, 0.1, 0.2, 3.3, 12.7, 12.8})
        EXPECT_NEAR(even.depth(at), k * at, 1e-12) << at;
    EXPECT_EQ(even.depth(-3), 0);
    EXPECT_NEAR(even.depth(99), k * mm, 1e-12);
    EXPECT_NEAR(even.at(5), std::exp(-k * 5), 1e-12);
    for (const auto& [from, to] :
         {std::pair{0.0, 12.8}, {0.0, 0.05}, {0.15, 0.25}, {1.0, 1.2}, {2.2, 7.7}, {5.0, 5.0}})
        EXPECT_NEAR(even.between(from, to), (std::exp(-k * from) - std::exp(-k * to)) / k, 1e-10)
            << from << " " << to;
    const LeftByOthers clear(mm, [](double, double) { return 1.0; });
    EXPECT_NEAR(clear.between(0.3, 9.1), 8.8, 1e-12);
    EXPECT_EQ(clear.at(4), 1);
    // Opaque from 6.4 mm on: e^-27.6 is left behind a part of a sixty-fourth of the ray.
    const LeftByOthers wall(mm, [](double from, double) { return from < 6.3999 ? 1.0 : 0.0; });
    EXPECT_EQ(wall.at(6.4), 1);
    EXPECT_NEAR(wall.at(6.6), 1e-12, 1e-15);
    EXPECT_NEAR(wall.depth(6.5), -0.5 * std::log(1e-12), 1e-9) << "linear within a part";
    EXPECT_NEAR(wall.between(0, 12.8), 6.4 + 0.2 / -std::log(1e-12), 1e-6);
}

/// The light of one channel, and how often it is asked for.
struct AskedLight {
    std::function<double(double)> of;
    mutable int times = 0;
    LightShares operator()(double u) const {
        ++times;
        LightShares shares{};
        shares.fill(-9); // of channels that nobody has
        shares[0] = of(u);
        return shares;
    }
};
/// The first channel at a place, as ambient light.
double ambientAt(const LightBetween& light, double u) {
    leaf::LightingNumbers lighting;
    lighting.channels = 1;
    lighting.occlusionChannel = 0;
    return light.at(u, lighting).ambient(1.0, 0);
}

TEST(LightsBetween, TakeAsFewPointsAsTheirShapeNeeds) {
    const auto asked = [](const std::function<double(double)>& of, const LightBetween::Need& need, double u0,
                          double u1, LightBetween& out) {
        AskedLight light{of};
        out.clear();
        out.add(u0, u1, 1, need, [&](double u) { return light(u); });
        return light.times;
    };
    const LightBetween::Need exact{1e-9, 1, 1};
    LightBetween light;
    EXPECT_EQ(asked([](double u) { return 0.2 + 0.5 * u; }, exact, 0.1, 0.9, light), 3);
    for (const double u : {0.1, 0.3, 0.77, 0.9})
        EXPECT_NEAR(ambientAt(light, u), 0.2 + 0.5 * u, 1e-12);
    EXPECT_NEAR(light.last()[0], 0.65, 1e-12);
    EXPECT_EQ(asked([](double u) { return 0.2 + u * u; }, exact, 0, 1, light), 5) << "a parabola";
    for (const double u : {0.0, 0.2, 0.5, 0.6, 1.0})
        EXPECT_NEAR(ambientAt(light, u), 0.2 + u * u, 1e-12);
    std::vector<double> joints;
    light.forEachJoint([&](double u) { joints.push_back(u); });
    EXPECT_EQ(joints, std::vector<double>{0.5});
    // What is not needed is not asked for: by the tolerance, or by the weight of the piece.
    const auto bent = [](double u) { return u < 0.5 ? 0.0 : u - 0.5; };
    EXPECT_EQ(asked(bent, {0.25, 1, 1}, 0, 1, light), 3);
    EXPECT_GT(asked(bent, {0.24, 1, 1}, 0, 1, light), 3);
    EXPECT_EQ(asked(bent, {0.01, 0.04, 1}, 0, 1, light), 3) << "0.25 of light is 0.01 of a colour";
    EXPECT_GT(asked(bent, {0.01, 0.041, 1}, 0, 1, light), 3);
    EXPECT_GT(asked(bent, {0.01, 0.04, 0.9}, 0, 1, light), 3) << "on a shorter part of the way";
    // A step: eight halvings around it, a piece of 1/256 with its ends on either side.
    const double step = 0.3;
    const int times = asked([&](double u) { return u < step ? 0.0 : 1.0; }, exact, 0, 1, light);
    EXPECT_EQ(times, 3 + 8 * 2);
    for (const double u : {0.0, 0.2, 0.29, 0.31, 0.6, 1.0})
        EXPECT_NEAR(ambientAt(light, u), u < step ? 0 : 1, 1e-12) << u;
    joints.clear();
    light.forEachJoint([&](double u) { joints.push_back(u); });
    const auto behind = std::upper_bound(joints.begin(), joints.end(), step);
    ASSERT_TRUE(behind != joints.begin() && behind != joints.end());
    EXPECT_EQ(*behind - *(behind - 1), 1.0 / 256);
    light.clear();
    LightShares even{};
    even[0] = 0.375;
    light.add(0.25, 0.25, even);
    EXPECT_EQ(ambientAt(light, 0.25), 0.375) << "of no length";
}

TEST(PairsOfNumbers, AreTwoNumbers) {
    const Pair a(3, -4), b(2, 8);
    const auto expect = [](const Pair& pair, double first, double second) {
        EXPECT_EQ(pair.first(), first);
        EXPECT_EQ(pair.second(), second);
    };
    expect(Pair(7), 7, 7);
    expect(a + b, 5, 4);
    expect(a - b, 1, -12);
    expect(a * b, 6, -32);
    expect(a / b, 1.5, -0.5);
    expect(min(a, b), 2, -4);
    expect(max(a, b), 3, 8);
    expect(abs(a), 3, 4);
    expect(sqrt(Pair(9, 16)), 3, 4);
    expect(select(a > b, a, b), 3, 8);
    expect(select(a <= b, a, b), 2, -4);
    expect(select(a > a, a, b), 2, 8);
    expect(select(a <= a, a, b), 3, -4);
}

/// How often a medium of an even extinction is looked at, of one length.
int looksAt(double extinction, int surfaces = 0) {
    int looks = 0;
    ReferenceIntegrator integral;
    for (int n = 0; n < surfaces; ++n)
        integral.addSurface(glm::dvec3(1), 1 - 1e-9);
    integral.add(0, 1, [&](double) { return ++looks, RadiantPoint{extinction, glm::dvec3(0.5)}; });
    return looks;
}

// Eight looks a panel. A panel up to a depth of 1 is compared with its halves; a deeper one is halved.
TEST(PanelsOfRays, AreAsManyAsTheirDepthNeeds) {
    EXPECT_EQ(looksAt(0), 8 * 3);
    EXPECT_EQ(looksAt(0.99), 8 * 3);
    EXPECT_EQ(looksAt(1.01), 8 * (3 + 4));
    EXPECT_EQ(looksAt(1.99), 8 * (3 + 4));
    EXPECT_EQ(looksAt(2.01), 8 * (3 + 4 + 8));
    EXPECT_EQ(looksAt(3.99), 8 * (3 + 4 + 8));
    // Behind a depth of 40 nothing counts: two surfaces of 1e-9 leave e^-41.4, one e^-20.7.
    EXPECT_EQ(looksAt(0.5, 1), 8 * 3);
    EXPECT_EQ(looksAt(0.5, 2), 0);
    ReferenceIntegrator integral;
    integral.add(0, 1, [](double) { return RadiantPoint{39.9, glm::dvec3(0.5)}; });
    EXPECT_FALSE(integral.opaque());
    integral.add(0, 1, [](double) { return RadiantPoint{0.2, glm::dvec3(0.5)}; });
    EXPECT_TRUE(integral.opaque());
    // The brighter a colour is, the larger are the differences that are its rounding: not halved without end.
    int looks = 0;
    ReferenceIntegrator bright;
    bright.add(0, 1, [&](double t) { return ++looks, RadiantPoint{0.5, glm::dvec3(1e6 * (1 + t * t))}; });
    EXPECT_LE(looks, 8 * 15);
    // The two ends of nothing, and of something turned round.
    looks = 0;
    ReferenceIntegrator none;
    none.add(1, 1, [&](double) { return ++looks, RadiantPoint{1, glm::dvec3(1)}; });
    none.add(2, 1, [&](double) { return ++looks, RadiantPoint{1, glm::dvec3(1)}; });
    EXPECT_EQ(looks, 0);
    EXPECT_EQ(none.alpha(), 0);
}

// Surfaces add to what is before them, and hide what is behind.
TEST(PanelsOfRays, SurfacesCompositeInOrder) {
    ReferenceIntegrator integral;
    integral.addSurface({1, 0, 0}, 0.25);
    integral.addSurface({0, 1, 0}, 0.5);
    integral.addSurface({0, 0, 1}, 1);
    integral.addSurface({1, 1, 1}, 1);
    EXPECT_NEAR(integral.colour().r, 0.25, 1e-15);
    EXPECT_NEAR(integral.colour().g, 0.75 * 0.5, 1e-15);
    EXPECT_NEAR(integral.colour().b, 0.375, 1e-15);
    EXPECT_EQ(integral.alpha(), 1);
    EXPECT_TRUE(integral.opaque());
}

} // namespace
} // namespace tessera
