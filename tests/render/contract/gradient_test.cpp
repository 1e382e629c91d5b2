// Gradients: forward, central (over a pitch and half of it), Sobel and analytic differences against closed
// forms, and their orders. Normals hold under any spacing and shear, and have no direction where the field
// has none.
#include "tests/support/scene_fixture.h"

#include <cmath>
#include <functional>
#include <glm/gtc/matrix_access.hpp>
#include <gtest/gtest.h>
#include <limits>
#include <random>

namespace tessera {
namespace {

using namespace tessera::test;

constexpr Gradient kGradientKinds[] = {Gradient::forward,  Gradient::central,     Gradient::sobel,
                                       Gradient::analytic, Gradient::centralHalf, Gradient::cubic,
                                       Gradient::sobel2,   Gradient::sobel4};
const std::string& nameOf(Gradient kind) {
    return gradientNames()[static_cast<std::size_t>(kind)];
}

/// A lattice of a formula's values at sample centres, of any size: nothing is stored.
struct Formula {
    std::function<double(const glm::dvec3&)> value; // of a place in voxels
    glm::ivec3 samples{40};
    double pitch = 1; // voxels
    glm::ivec3 extent() const { return samples; }
    double at(const glm::ivec3& i) const { return value(pitch * (glm::dvec3(i) + 0.5)); }
};

/// Places at least five samples inside the outermost ones.
std::vector<glm::dvec3> insidePlaces(const Formula& field, int count) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> unit(0, 1);
    std::vector<glm::dvec3> out;
    for (int i = 0; i < count; ++i)
        out.push_back(field.pitch * (5.5 + glm::dvec3(unit(random), unit(random), unit(random)) *
                                               (glm::dvec3(field.samples) - 11.0)));
    return out;
}

double differ(const glm::dvec3& a, const glm::dvec3& b) {
    return glm::length(a - b);
}

TEST(Gradients, AreExactForWhatTheirFormulaIs) {
    for (const double pitch : {1.0, 2.0, 8.0}) {
        const auto gradient = [&](const Formula& f, const glm::dvec3& p, Gradient kind) {
            return fieldGradient(f, p, 1 / f.pitch, kind);
        };
        const glm::dvec3 slope(3, -0.5, 11);
        const Formula linear{
            [&](const glm::dvec3& p) { return glm::dot(slope, p) - 100; }, {20, 22, 24}, pitch};
        const Formula quadratic{[](const glm::dvec3& p) {
                                    return p.x * p.x - 2 * p.y * p.y + 0.5 * p.z * p.z + p.x * p.y -
                                           3 * p.y * p.z + p.x;
                                },
                                {20, 22, 24},
                                pitch};
        const auto quadraticSlope = [](const glm::dvec3& p) {
            return glm::dvec3(2 * p.x + p.y + 1, -4 * p.y + p.x - 3 * p.z, p.z - 3 * p.y);
        };
        const Formula saddle{[](const glm::dvec3& p) { return p.x * p.y * p.z; }, {20, 22, 24}, pitch};
        for (const glm::dvec3& p : insidePlaces(linear, 500)) {
            for (const Gradient kind : kGradientKinds)
                ASSERT_LE(differ(gradient(linear, p, kind), slope), 1e-10) << nameOf(kind);
            // Of a quadratic field, too, anywhere between samples.
            for (const Gradient kind : {Gradient::central, Gradient::centralHalf, Gradient::sobel,
                                        Gradient::cubic, Gradient::sobel2})
                ASSERT_LE(differ(gradient(quadratic, p, kind), quadraticSlope(p)), 1e-8) << nameOf(kind);
            // A saddle is what a trilinear cell can be.
            ASSERT_LE(
                differ(gradient(saddle, p, Gradient::analytic), glm::dvec3(p.y * p.z, p.z * p.x, p.x * p.y)),
                1e-8);
        }
        // x^3 at samples' centres: 3x^2 and the squared pitch (T16); x^2 to one side: one pitch too much.
        const Formula cube{[](const glm::dvec3& p) { return p.x * p.x * p.x; }, {20, 5, 5}, pitch};
        const Formula square{[](const glm::dvec3& p) { return p.x * p.x; }, {20, 5, 5}, pitch};
        for (int i = 2; i < 18; ++i) {
            const glm::dvec3 p = pitch * (glm::dvec3(i, 2, 2) + 0.5);
            for (const Gradient kind :
                 {Gradient::central, Gradient::centralHalf, Gradient::sobel, Gradient::cubic})
                EXPECT_NEAR(gradient(cube, p, kind).x, 3 * p.x * p.x + pitch * pitch, 1e-8) << nameOf(kind);
            for (const Gradient kind : {Gradient::forward, Gradient::analytic})
                EXPECT_NEAR(gradient(square, p, kind).x, 2 * p.x + pitch, 1e-9) << nameOf(kind);
        }
    }
}

/// 5^3 samples of white noise.
struct Noise {
    std::vector<double> values = std::vector<double>(125);
    Noise() {
        std::mt19937 random(3);
        std::uniform_real_distribution<double> unit(-1, 1);
        for (double& v : values)
            v = unit(random);
    }
    glm::ivec3 extent() const { return glm::ivec3(5); }
    double at(const glm::ivec3& i) const {
        return values[static_cast<std::size_t>((i.z * 5 + i.y) * 5 + i.x)];
    }
};

// The default: what VTK's and 3D Slicer's mappers shade by. The field's own kinks show in it nowhere else.
TEST(Gradients, CentralIsTrilinearBetweenTheDifferencesOfTheLattice) {
    const Noise noise;
    std::mt19937 random(11);
    std::uniform_real_distribution<double> unit(1.5, 3.5); // between samples with neighbours on both sides
    for (int n = 0; n < 1000; ++n) {
        const glm::dvec3 p(unit(random), unit(random), unit(random));
        const glm::dvec3 g = fieldGradient(noise, p, 1.0, Gradient::central);
        for (int axis = 0; axis < 3; ++axis) {
            struct Differences {
                const Noise& noise;
                glm::ivec3 side{0};
                glm::ivec3 extent() const { return noise.extent(); }
                double at(const glm::ivec3& i) const {
                    return 0.5 * (noise.at(glm::min(i + side, 4)) - noise.at(glm::max(i - side, 0)));
                }
            } differences{noise};
            differences.side[axis] = 1;
            ASSERT_NEAR(g[axis], fieldValue(differences, p, 1.0), 1e-14) << n;
        }
    }
}

// Across planes of samples it and its own slope go on: what the others' kinks make of a lit surface it does
// not.
TEST(Gradients, CubicIsSmoothAndConvolvesTheSamplesWithTheSpline) {
    const Noise noise;
    const auto spline = [](double x) {
        const double a = std::abs(x);
        return a < 1 ? 2.0 / 3 - a * a * (1 - a / 2) : a < 2 ? (2 - a) * (2 - a) * (2 - a) / 6 : 0.0;
    };
    const auto slope = [](double x) {
        const double a = std::abs(x), s = x < 0 ? -1 : 1;
        return s * (a < 1 ? a * (1.5 * a - 2) : a < 2 ? -(2 - a) * (2 - a) / 2 : 0.0);
    };
    std::mt19937 random(13);
    std::uniform_real_distribution<double> unit(1.5, 3.5);
    const auto at = [&](const glm::dvec3& p) { return fieldGradient(noise, p, 1.0, Gradient::cubic); };
    for (int n = 0; n < 200; ++n) {
        glm::dvec3 p(unit(random), unit(random), unit(random));
        glm::dvec3 expected(0);
        for (int i = 0; i < 125; ++i) {
            const glm::dvec3 d = p - 0.5 - glm::dvec3(i % 5, i / 5 % 5, i / 25);
            const double v = noise.at({i % 5, i / 5 % 5, i / 25});
            expected +=
                v * glm::dvec3(slope(d.x) * spline(d.y) * spline(d.z), spline(d.x) * slope(d.y) * spline(d.z),
                               spline(d.x) * spline(d.y) * slope(d.z));
        }
        ASSERT_LE(differ(at(p), expected), 1e-14) << n;
        const int axis = n % 3;
        constexpr double kStep = 1e-5;
        glm::dvec3 step(0);
        step[axis] = kStep;
        p[axis] = 2.5; // on a plane of samples
        const glm::dvec3 before = (at(p) - at(p - step)) / kStep, after = (at(p + step) - at(p)) / kStep;
        ASSERT_LE(differ(before, after), 1e-4) << n;
    }
}

TEST(Gradients, SobelIsThatOfTheNeighbouringSamples) {
    const Noise samples;
    glm::dvec3 expected(0);
    for (int n = 0; n < 27; ++n) {
        const glm::ivec3 side = glm::ivec3(n % 3, n / 3 % 3, n / 9) - 1;
        const auto across = [&](int axis) { return side[axis] == 0 ? 2.0 : 1.0; };
        for (int axis = 0; axis < 3; ++axis)
            expected[axis] +=
                side[axis] * across((axis + 1) % 3) * across((axis + 2) % 3) * samples.at(side + 2) / 32;
    }
    EXPECT_LE(differ(fieldGradient(samples, glm::dvec3(2.5), 1.0, Gradient::sobel), expected), 1e-14);
}

// White noise: the slopes of smooth normals scatter by what their weights say, an eighth and a 32nd of
// pitches apart.
TEST(Gradients, SmoothOnesScatterLess) {
    const auto scatter = [](Gradient kind) {
        std::mt19937 random(5);
        std::normal_distribution<double> normal;
        std::vector<double> values(21 * 21 * 21);
        for (double& v : values)
            v = normal(random);
        const Formula field{[&](const glm::dvec3& p) {
                                const glm::ivec3 i(p);
                                return values[static_cast<std::size_t>((i.z * 21 + i.y) * 21 + i.x)];
                            },
                            glm::ivec3(21)};
        double squares = 0;
        int count = 0;
        for (int z = 5; z < 16; ++z)
            for (int y = 5; y < 16; ++y)
                for (int x = 5; x < 16; ++x, ++count)
                    squares += std::pow(fieldGradient(field, glm::dvec3(x, y, z) + 0.5, 1.0, kind).x, 2);
        return std::sqrt(squares / count);
    };
    // Of 1:2:1 across twice, the root of the sum of squared weights is 6/16, times the root of 2, over 2 h.
    for (const Gradient kind : {Gradient::sobel, Gradient::sobel2, Gradient::sobel4})
        EXPECT_NEAR(scatter(kind), 6.0 / 16 * std::sqrt(2) / (2 * reachOf(kind)), 0.05 / reachOf(kind))
            << nameOf(kind);
    EXPECT_NEAR(scatter(Gradient::central), std::sqrt(0.5), 0.05);
}

// Halving the pitch of a smooth field's samples: order 2 for symmetric differences, 1 for the others.
TEST(Gradients, HaveTheirOrders) {
    const auto value = [](const glm::dvec3& p) {
        return std::sin(1.3 * p.x + 0.4) * std::cos(0.7 * p.y) + 0.5 * std::sin(p.z + 0.3 * p.x);
    };
    const auto slope = [](const glm::dvec3& p) {
        const double a = 1.3 * p.x + 0.4, b = 0.7 * p.y, c = p.z + 0.3 * p.x;
        return glm::dvec3(1.3 * std::cos(a) * std::cos(b) + 0.15 * std::cos(c),
                          -0.7 * std::sin(a) * std::sin(b), 0.5 * std::cos(c));
    };
    for (const Gradient kind : kGradientKinds) {
        const auto error = [&](double pitch) {
            const Formula field{value, glm::ivec3(static_cast<int>(8 / pitch)), pitch};
            double sum = 0;
            const auto places = insidePlaces(field, 4000);
            for (const glm::dvec3& p : places)
                sum += std::pow(differ(fieldGradient(field, p, 1 / pitch, kind), slope(p)), 2);
            return std::sqrt(sum / static_cast<double>(places.size()));
        };
        const double order = std::log2(error(1.0 / 8) / error(1.0 / 64)) / 3;
        RecordProperty(nameOf(kind), std::to_string(order));
        const bool toOneSide = kind == Gradient::forward || kind == Gradient::analytic;
        EXPECT_NEAR(order, toOneSide ? 1 : 2, 0.15) << nameOf(kind);
    }
}

// A sphere's normals, in patient space, with spacings that differ a thousandfold and with shear: what shade()
// takes for the normal is the gradient by the inverse transpose.
TEST(Gradients, NormalsOfASphereAreRadialUnderAnySpacing) {
    glm::dmat3 sheared(0);
    sheared[0] = {1, 0, 0};
    sheared[1] = {0.3, 1, 0};
    sheared[2] = {0.4, -0.7, 2.5};
    glm::dmat3 flat(1);
    flat[2] = {0, 0, 1000};
    glm::dmat3 both(1);
    both[1] = {0.5, 1, 0};
    both[2] = {300, -200, 1000};
    for (const glm::dmat3& patientFromVoxel : {sheared, flat, both}) {
        // A radius of 25 of the longest spacing, and the sphere in the middle of its own box of voxels.
        const double radius = 25 * glm::length(patientFromVoxel[2]);
        const glm::dmat3 voxelFromPatient = glm::inverse(patientFromVoxel);
        const glm::dvec3 reach =
            1.2 * radius *
            glm::dvec3(glm::length(glm::row(voxelFromPatient, 0)), glm::length(glm::row(voxelFromPatient, 1)),
                       glm::length(glm::row(voxelFromPatient, 2)));
        const Formula ball{[&](const glm::dvec3& p) { return glm::length(patientFromVoxel * (p - reach)); },
                           glm::ivec3(2.0 * reach) + 4};
        std::mt19937 random(5);
        std::normal_distribution<double> normal;
        double worst[std::size(kGradientKinds)] = {};
        for (int i = 0; i < 2000; ++i) {
            const glm::dvec3 radial =
                glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
            const glm::dvec3 p = reach + voxelFromPatient * (radius * radial);
            for (const Gradient kind : kGradientKinds) {
                const glm::dvec3 g = glm::transpose(voxelFromPatient) * fieldGradient(ball, p, 1.0, kind);
                const double angle = std::atan2(glm::length(glm::cross(g, radial)), glm::dot(g, radial));
                double& most = worst[static_cast<int>(kind)];
                most = std::max(most, angle * 57.29577951308232);
            }
        }
        // Degrees; h/R is 1/25: second order, and first order with half of it in the derivative.
        EXPECT_LE(worst[static_cast<int>(Gradient::central)], 0.15);
        EXPECT_LE(worst[static_cast<int>(Gradient::centralHalf)], 0.15);
        EXPECT_LE(worst[static_cast<int>(Gradient::sobel)], 0.3);
        EXPECT_LE(worst[static_cast<int>(Gradient::cubic)], 0.15);
        EXPECT_LE(worst[static_cast<int>(Gradient::sobel2)], 1.2);
        EXPECT_LE(worst[static_cast<int>(Gradient::sobel4)], 5);
        EXPECT_LE(worst[static_cast<int>(Gradient::forward)], 2.5);
        EXPECT_LE(worst[static_cast<int>(Gradient::analytic)], 2.5);
        for (const Gradient kind : kGradientKinds)
            RecordProperty(nameOf(kind), std::to_string(worst[static_cast<int>(kind)]));
    }
}

// No direction: the colour stays as it is, for every kind, and never is NaN.
TEST(Gradients, ZeroIsUnlitAndNeverNan) {
    VolumeInfo info;
    for (const glm::dvec3& spacing : {glm::dvec3(1), glm::dvec3(1, 1, 1000), glm::dvec3(1e-3)}) {
        info.patientFromVoxel = glm::dmat4(1);
        for (int axis = 0; axis < 3; ++axis)
            info.patientFromVoxel[axis] *= spacing[axis];
        const Optics optics = makeOptics(makeTable(TransferFunction::fromOpacity({{0, 0}, {1, 0.5}}, {}, 1)),
                                         info, Shading{}, 0);
        const glm::vec3 colour(0.25f, 0.5f, 0.75f);
        std::mt19937 random(9);
        for (const glm::ivec3& samples :
             {glm::ivec3(1), glm::ivec3(33, 1, 70), glm::ivec3(1, 1, 2), glm::ivec3(20)})
            for (const double constant : {0.0, 0.1, -1024.3, 65535.0, 3e30, 1e-40})
                for (const Gradient kind : kGradientKinds)
                    for (int i = 0; i < 200; ++i) {
                        const Formula field{[&](const glm::dvec3&) { return constant; }, samples};
                        std::uniform_real_distribution<float> unit(-0.1f, 1.1f);
                        const glm::vec3 p =
                            glm::vec3(samples) * glm::vec3(unit(random), unit(random), unit(random));
                        const glm::vec3 g = fieldGradient(field, p, 1.0f, kind);
                        ASSERT_EQ(g, glm::vec3(0)) << nameOf(kind) << " of " << constant;
                        ASSERT_EQ(shade(optics, colour, g, glm::normalize(glm::vec3(1, 2, 3))), colour);
                    }
        // Along an axis of one sample there is no slope, along the others there is.
        const Formula slab{[](const glm::dvec3& p) { return p.x + 2 * p.z; }, {33, 1, 70}};
        for (const Gradient kind : kGradientKinds) {
            const glm::dvec3 g = fieldGradient(slab, glm::dvec3(11.3, 0.2, 22.6), 1.0, kind);
            EXPECT_NEAR(g.x, 1, 1e-12) << nameOf(kind);
            EXPECT_EQ(g.y, 0) << nameOf(kind);
            EXPECT_NEAR(g.z, 2, 1e-12) << nameOf(kind);
            const glm::dvec3 lit = shade(optics, glm::dvec3(colour), g, glm::dvec3(0, 0.6, 0.8));
            EXPECT_TRUE(std::isfinite(lit.x + lit.y + lit.z));
        }
    }
}

// The derivative of blends between levels, against differences of the very field over a millionth of a voxel.
TEST(Gradients, AnalyticOneIsTheDerivativeOfMixedLevels) {
    for (const EdgeFunction edge :
         {EdgeFunction::nearest, EdgeFunction::minimum, EdgeFunction::split, EdgeFunction::maximum}) {
        MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
        const VolumeInfo info = StoreReader(storePath("sphere"), ram).info();
        Scene scene = sceneOn(info, "auto", 0, {8, 8});
        scene.quality.edgeFunction = edge;
        Prepared prepared("sphere", scene);
        Selection selection = prepared.p.layer().selection;
        std::mt19937 random(21);
        selection.counts = {};
        for (std::uint8_t& level : selection.levels)
            ++selection.counts[level = static_cast<std::uint8_t>(random() % (kLevelCount + 1))];
        prepared.p.setSelection(selection);
        MixedReader samples(*prepared.p.layer().cache, info, prepared.p.layer().selection,
                            prepared.p.layer().levels);
        std::uniform_real_distribution<double> unit(0, 1);
        int blended = 0, compared = 0;
        for (int i = 0; i < 20000; ++i) {
            const glm::dvec3 p =
                glm::dvec3(info.extentVoxels) * glm::dvec3(unit(random), unit(random), unit(random));
            const auto value = [&](const glm::dvec3& at) { return interblockValue(samples, at); };
            const glm::dvec3 fine = centralDifferences(value, p, 1e-6);
            if (differ(fine, forwardDifferences(value, p, 4e-6)) > 1e-3)
                continue; // beside a place where the derivative jumps
            const glm::dvec3 g = interblockGradient(samples, p, Gradient::analytic);
            ASSERT_LE(differ(g, fine), 1e-4 * (1 + glm::length(fine)))
                << edgeFunctionNames()[static_cast<std::size_t>(edge)];
            ++compared;
            const auto place =
                cornerPlace(p, glm::dvec3(info.extentVoxels), prepared.p.layer().levels.bricks);
            const BrickCorner& corner = prepared.p.layer().levels.at(place.corner);
            blended += !corner.agree() && nearAxes(corner, place.offset) != 0;
        }
        EXPECT_GT(compared, 10000);
        EXPECT_TRUE(edge == EdgeFunction::nearest || blended > 500) << blended;
    }
}

// The scene's choice reaches GPU ray caster and mirror, and nothing else is compiled.
TEST(Gradients, TheScenesChoiceIsDrawn) {
    const GlContext context({"software"});
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    const VolumeInfo info = StoreReader(storePath("torso"), ram).info();
    std::vector<Image> pictures;
    for (const Gradient kind : kGradientKinds) {
        Scene scene = sceneOn(info, "bone-1", 0, {24, 24});
        scene.shading.gradient = kind;
        Prepared prepared("torso", scene);
        const std::uint32_t features = marchFeatures(prepared.p, false);
        EXPECT_EQ(features & kGradientFeatures, gradientFeature(kind));
        const GpuPicture picture = marchOn(prepared, features);
        Work work;
        const auto mirrored = mirrorRays<float>(mirrorInput(prepared.p, true), 24 * 24,
                                                frameRays(cast<float>(prepared.p.view.frame)), 0, work);
        float worst = 0;
        for (std::size_t i = 0; i < mirrored.size(); ++i)
            for (int c = 0; c < 4; ++c)
                worst = std::max(worst, std::abs(picture.image.pixels[i][c] - mirrored[i][c]));
        EXPECT_LE(worst, 1e-5f) << nameOf(kind); // rays differ by rounding: render_contract_test.cpp
        EXPECT_EQ(picture.work.samples, work.samples) << nameOf(kind);
        for (const Image& other : pictures)
            EXPECT_FALSE(bitEqual(other, picture.image)) << nameOf(kind);
        pictures.push_back(picture.image);
        scene.shading.on = false;
        EXPECT_EQ(marchFeatures(Prepared("torso", scene).p, false) & kGradientFeatures, 0u);
    }
}

} // namespace
} // namespace tessera
