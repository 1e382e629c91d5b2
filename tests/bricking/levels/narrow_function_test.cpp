// tests/bricking/levels/narrow_function_test.cpp: rays composited under functions too narrow for look-ups,
// against dense integration and against all rays of a brick.
#include "bricking/levels/level_error.h"
#include "bricking/levels/ray_compositing.h"
#include "core/image/colour.h"
#include "tests/support/blobs.h"
#include "tests/support/bricking_selection_tools.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using test::Blobs;
using test::plainInfo;
using test::raysOf;

/// Opaque where it is crossed, whatever its width.
TransferFunction spike(double at, double width) {
    return TransferFunction::fromOpacity({{at - width / 2, 0}, {at, 0.9}, {at + width / 2, 0}},
                                         {{at - 50, {0.9, 0.8, 0.6}}, {at + 50, {0.2, 0.8, 0.9}}},
                                         0.01 * width);
}

TEST(NarrowFunction, KnowsNarrowFromWide) {
    const auto narrownessOf = [](const TransferFunction& function, double width) {
        const TransferTable table = makeTable(function);
        return narrowness(FunctionSums(table), width * static_cast<double>(table.entriesPerValue));
    };
    const auto extinction = [](std::vector<OpacityPoint> points) {
        return TransferFunction::fromExtinction(std::move(points), {});
    };
    EXPECT_NEAR(narrownessOf(spike(250, 0.7), 30), 2, 0.1); // all of it lies elsewhere
    EXPECT_LT(narrownessOf(extinction({{0, 0}, {300, 1}}), 30), 0.03);
    EXPECT_LT(narrownessOf(extinction({{0, 0}, {0, 1}}), 30), 0.1); // a step: shown for all values above
    EXPECT_EQ(narrownessOf(extinction({{0, 0}, {300, 0}}), 30), 0);
    EXPECT_EQ(narrownessOf(extinction({{0, 1}, {300, 1}}), 0), 0);
    // A triangle as wide as what it is averaged over: between the two.
    EXPECT_GT(narrownessOf(extinction({{0, 0}, {15, 1}, {30, 0}}), 30), 0.5);
    EXPECT_LT(narrownessOf(extinction({{0, 0}, {150, 1}, {300, 0}}), 30), 0.1);
}

// The means over what segments pass, by a million samples of the function itself.
TEST(NarrowFunction, CompositesWhatDenseSamplingDoes) {
    VolumeInfo info = plainInfo({32, 32, 32}, ValueType::f32);
    info.rescaleSlope = 1.5;
    info.rescaleIntercept = -10;
    BrickRayPart part;
    part.lo = -300;
    part.hi = 700;
    const std::vector<std::uint8_t> codes = {10, 90, 140, 255, 3, 120, 77, 150, 149};
    for (const double width : {0.8, 40.0}) {
        const TransferFunction function = spike(250, width);
        const TransferTable table = makeTable(function);
        const FunctionSums sums(table);
        NarrowCompositor compositor(sums, table, info);
        compositor.setPart(part);
        // Thin enough that light reaches the end.
        const double segmentMm = 2;
        const glm::dvec4 made = compositor.composite(codes, segmentMm);
        const auto valueOf = [&](double code) { return 1.5 * (-300 + 1000 * code / 255) - 10; };
        glm::dvec3 colour(0);
        double through = 1;
        constexpr int kSamples = 200000;
        for (std::size_t j = 0; j < codes.size(); ++j) {
            const double here = codes[j], before = j > 0 ? 0.5 * (codes[j - 1] + here) : here;
            const double behind = j + 1 < codes.size() ? 0.5 * (codes[j + 1] + here) : here;
            glm::dvec4 mean(0);
            for (int i = 0; i < kSamples; ++i) {
                const double u = (i + 0.5) / kSamples * 2 - 1;
                double code = u < 0 ? here + u * (here - before) : here + u * (behind - here);
                if ((u < 0 && before == here) ||
                    (u > 0 && behind == here)) // all values that the code stands for
                    code = std::clamp(here + (u < 0 ? u + 0.5 : u - 0.5), here == 0 ? here : here - 0.5,
                                      here + 0.5);
                const double value = valueOf(code), extinction = function.extinction(value);
                mean += glm::dvec4(extinction * function.colour(value), extinction) / double(kSamples);
            }
            const double alpha = -std::expm1(-mean.a * segmentMm);
            if (mean.a > 0)
                colour += through * alpha / mean.a * glm::dvec3(mean);
            through *= 1 - alpha;
        }
        EXPECT_LT(through, 0.9); // something is met
        EXPECT_GT(through, 0.01);
        // The table of the function is what is off.
        EXPECT_NEAR(made.a, through, 0.01) << width;
        for (int channel = 0; channel < 3; ++channel)
            EXPECT_NEAR(made[channel], colour[channel], 0.01) << width;
    }
}

/// Error of a level over all rows of voxels, the value steady from voxel to voxel.
double trueError(const Blobs& b, int level, const TransferTable& table) {
    const BrickFields fields = b.fields();
    const FunctionSums sums(table);
    const auto place = [&](double value) {
        return (value - static_cast<double>(table.firstValue)) * static_cast<double>(table.entriesPerValue);
    };
    double sum = 0, count = 0;
    for (int axis = 0; axis < 3; ++axis)
        for (int q = 0; q < 32; ++q)
            for (int p = 0; p < 32; ++p) {
                glm::dvec3 luv[2];
                for (const int which : {0, 1}) {
                    glm::dvec3 colour(0);
                    double through = 1, before = 0;
                    for (int i = 0; i < 32; ++i) {
                        glm::dvec3 at(p + 0.5);
                        at[axis] = i + 0.5;
                        at[(axis + 2) % 3] = q + 0.5;
                        const double here = place(static_cast<double>(fields.at(which == 0 ? 0 : level, at)));
                        if (i > 0 && here != before) {
                            const glm::dvec4 mean = (sums.upTo(here) - sums.upTo(before)) / (here - before);
                            if (mean.a > 0) {
                                const double alpha = -std::expm1(-mean.a);
                                colour += through * alpha / mean.a * glm::dvec3(mean);
                                through *= 1 - alpha;
                            }
                        }
                        before = here;
                    }
                    luv[which] = luvFromLinear(colour);
                }
                sum += glm::length(luv[1] - luv[0]);
                ++count;
            }
    return sum / count;
}

TEST(NarrowFunction, LevelsAreToldApartUnderASpike) {
    const VolumeInfo info = plainInfo({32, 32, 32}, ValueType::f32);
    for (const std::uint64_t seed : {3u, 44u, 555u}) {
        const std::vector<Blobs> brick = {Blobs({32, 32, 32}, seed)};
        // Met by half of the rays or so: looked up at samples, next to nothing would be.
        const TransferTable table = makeTable(spike(110, 1.0 / 16));
        const LevelErrors e = rayErrors(raysOf(brick, {1, 1, 1}), {1}, table, info);
        EXPECT_LT(e.transmittances[0], 0.9f);
        for (int level = 1; level < kLevelCount; ++level) {
            const double truth = trueError(brick[0], level, table);
            const auto predicted = static_cast<double>(e.errors[0][static_cast<std::size_t>(level)]);
            EXPECT_GT(truth, 5) << "seed " << seed << " level " << level;
            EXPECT_GT(predicted, 0.5 * truth) << "seed " << seed << " level " << level;
            EXPECT_LT(predicted, 2 * truth) << "seed " << seed << " level " << level;
        }
    }
}

} // namespace
} // namespace tessera
