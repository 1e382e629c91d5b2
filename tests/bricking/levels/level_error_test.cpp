// tests/bricking/levels/level_error_test.cpp: predicted errors against a slow computation and against all
// rays of a brick; the rays themselves.
#include "core/image/colour.h"
#include "core/scene/transfer_function.h"
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
using test::randomErrors;
using test::raysOf;

TransferTable testTable() {
    return makeTable(
        TransferFunction::fromOpacity({{-20, 0}, {30, 0.08}, {60, 0}, {80, 0.5}},
                                      {{-20, {1, 0.2, 0.1}}, {50, {0.2, 0.9, 0.3}}, {100, {1, 1, 1}}}, 1));
}

/// The definition in level_error.h, from the codes, in double, without tables.
double slowError(const BrickRays& rays, std::uint32_t row, int level, const TransferTable& table,
                 const VolumeInfo& info, const glm::ivec3& size) {
    const auto coloured = [&](const BrickRayPart& part, int ray, int at, bool fromItsEnd) {
        std::size_t code = static_cast<std::size_t>(ray * kSamplesPerRay);
        for (int l = 0; l < at; ++l)
            code += static_cast<std::size_t>(kRaySamples[static_cast<std::size_t>(l)]);
        const int samples = kRaySamples[static_cast<std::size_t>(at)], axis = part.axis(ray);
        // Segments: a sample each, but two of level 2 and 3, four of level 4 and 5, each time a quarter of
        // the way to the next.
        std::vector<double> codes(part.codes.begin() + static_cast<std::ptrdiff_t>(code),
                                  part.codes.begin() + static_cast<std::ptrdiff_t>(code) + samples);
        for (int n = 0; n < (at < 2 ? 0 : at < 4 ? 1 : 2); ++n) {
            std::vector<double> twice;
            for (std::size_t j = 0; j < codes.size(); ++j) {
                twice.push_back((3 * codes[j] + codes[j > 0 ? j - 1 : 0]) / 4);
                twice.push_back((3 * codes[j] + codes[std::min(j + 1, codes.size() - 1)]) / 4);
            }
            codes = twice;
        }
        if (fromItsEnd)
            std::reverse(codes.begin(), codes.end());
        glm::dvec3 colour(0);
        double through = 1;
        for (const double segment : codes) {
            const double stored =
                static_cast<double>(part.lo) +
                (static_cast<double>(part.hi) - static_cast<double>(part.lo)) * segment / 255;
            const double value = info.rescaleSlope * stored + info.rescaleIntercept;
            const double entry = std::clamp((value - static_cast<double>(table.firstValue)) *
                                                static_cast<double>(table.entriesPerValue),
                                            0.0, static_cast<double>(table.entries.size() - 1));
            const auto left = std::min(static_cast<std::size_t>(entry), table.entries.size() - 2);
            const glm::dvec4 e =
                glm::mix(glm::dvec4(table.entries[left]), glm::dvec4(table.entries[left + 1]),
                         entry - static_cast<double>(left));
            const double alpha =
                -std::expm1(-e.a * info.spacingMm()[axis] * size[axis] / static_cast<double>(codes.size()));
            colour += through * alpha * glm::dvec3(e);
            through *= 1 - alpha;
        }
        return luvFromLinear(colour);
    };
    double sum = 0;
    for (int p = 0; p < kBrickRayParts; ++p) {
        const BrickRayPart part = decodeRays(rays.part(row, p));
        for (int ray = 0; ray < kRaysPerPart; ++ray)
            sum += (ray < 11 ? 15.0 / 16 / 11 : 1.0 / 16) / 2 *
                   glm::length(coloured(part, ray, level, seenFromItsEnd(p, ray)) -
                               coloured(part, ray, 0, seenFromItsEnd(p, ray)));
    }
    return sum;
}

TEST(PredictErrors, EqualTheDefinition) {
    VolumeInfo info = plainInfo({64, 32, 20}, ValueType::f32);
    info.patientFromVoxel = patientFromVoxelOf({0, 0, 0}, {0.5, 0, 0}, {0, 0.7, 0}, {0, 0, 2.5});
    info.rescaleSlope = 1.5;
    info.rescaleIntercept = -10;
    const std::vector<Blobs> bricks = {Blobs({32, 32, 20}, 5), Blobs({32, 32, 20}, 900)};
    const BrickRays rays = raysOf(bricks, {2, 1, 1});
    const TransferTable table = testTable();
    const LevelErrors e = rayErrors(rays, {1, 1}, table, info);
    for (std::uint32_t b = 0; b < 2; ++b) {
        EXPECT_EQ(e.errors[b][0], 0);
        for (int level = 1; level < kLevelCount; ++level) {
            const double expected = slowError(rays, b, level, table, info, bricks[b].size);
            EXPECT_GT(expected, 0.5); // there is something to tell apart
            // Nearest of 4096 entries instead of linear between 256, in float.
            EXPECT_NEAR(static_cast<double>(e.errors[b][static_cast<std::size_t>(level)]), expected,
                        0.02 * expected + 0.02);
        }
    }
    EXPECT_EQ(rayErrors(rays, {1, 1}, table, info, 1).errors, rayErrors(rays, {1, 1}, table, info, 3).errors);
    const LevelErrors half = rayErrors(rays, {0, 1}, table, info);
    EXPECT_EQ(half.errors[0], (std::array<float, kLevelCount>{}));
    EXPECT_EQ(half.errors[1], e.errors[1]);
}

TEST(PredictErrors, AreSmoothedAsDocumented) {
    LevelErrors e;
    e.bricks = {3, 1, 1};
    e.shows = {1, 1, 0};
    e.errors = {{0, 1, 2, 3, 4, 5}, {0, 0, 0, 0, 0, 10}, {}};
    LevelErrors single = e;
    single.shows = {1, 0, 0};
    single.errors[1] = {};
    smoothErrors(e, 1);
    const double a[6] = {0, 0.9, 1.8, 2.7, 3.6, 5.5},
                 b[6] = {0, 0.1, 0.2, 0.3, 0.4, 9.5}; // a tenth of the other
    for (std::size_t level = 1; level < kLevelCount; ++level) {
        const double share = (a[level] + b[level]) / 25;
        EXPECT_NEAR(static_cast<double>(e.errors[0][level]), 0.75 * a[level] + 0.25 * 14.5 * share, 1e-5);
        EXPECT_NEAR(static_cast<double>(e.errors[1][level]), 0.75 * b[level] + 0.25 * 10.5 * share, 1e-5);
        EXPECT_EQ(e.errors[2][level], 0);
    }
    smoothErrors(single);
    for (std::size_t level = 1; level < kLevelCount; ++level)
        EXPECT_NEAR(single.errors[0][level], static_cast<float>(level), 1e-5f);
    const LevelErrors many = randomErrors({11, 12, 13}, 4);
    LevelErrors one = many, three = many;
    smoothErrors(one, 1);
    smoothErrors(three, 3);
    EXPECT_EQ(one.errors, three.errors);
}

/// The truth that the rays stand for: all rows of voxels, sampled at every voxel.
double trueError(const Blobs& b, int level, const TransferTable& table, const glm::dvec3& spacing) {
    const BrickFields fields = b.fields();
    // Gradient opacity: of central differences over a pitch to either side, as far as the brick goes.
    const auto factor = [&](int at, const glm::dvec3& p) {
        if (table.gradientOpacity.isOne())
            return 1.0;
        const double pitch = std::min(1 << at, 16);
        glm::dvec3 gradient(0);
        for (int axis = 0; axis < 3; ++axis) {
            glm::dvec3 up = p, down = p;
            up[axis] = std::min(p[axis] + pitch, b.size[axis] - 0.5);
            down[axis] = std::max(p[axis] - pitch, 0.5);
            gradient[axis] = static_cast<double>(fields.at(at, up) - fields.at(at, down)) /
                             ((up[axis] - down[axis]) * spacing[axis]);
        }
        return table.gradientOpacity.factor(glm::length(gradient));
    };
    double sum = 0, count = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const int u = (axis + 1) % 3, w = (axis + 2) % 3;
        for (int q = 0; q < b.size[w]; ++q)
            for (int p = 0; p < b.size[u]; ++p) {
                glm::dvec3 luv[2];
                for (int which = 0; which < 2; ++which) {
                    glm::dvec3 colour(0);
                    double through = 1;
                    for (int i = 0; i < b.size[axis]; ++i) {
                        glm::dvec3 at;
                        at[axis] = i + 0.5;
                        at[u] = p + 0.5;
                        at[w] = q + 0.5;
                        const double value = static_cast<double>(fields.at(which == 0 ? 0 : level, at));
                        const double x = std::clamp((value - static_cast<double>(table.firstValue)) *
                                                        static_cast<double>(table.entriesPerValue),
                                                    0.0, static_cast<double>(table.entries.size() - 1));
                        const glm::dvec4 e(table.entries[static_cast<std::size_t>(std::lround(x))]);
                        const double alpha =
                            -std::expm1(-e.a * factor(which == 0 ? 0 : level, at) * spacing[axis]);
                        colour += through * alpha * glm::dvec3(e);
                        through *= 1 - alpha;
                    }
                    luv[which] = luvFromLinear(colour);
                }
                sum += glm::length(luv[1] - luv[0]);
                ++count;
            }
    }
    return sum / count;
}

TEST(PredictErrors, AreCloseToTheErrorOfAllRays) {
    const VolumeInfo info = plainInfo({32, 32, 32}, ValueType::f32);
    const TransferTable table = testTable();
    for (const std::uint64_t seed : {3u, 44u, 555u, 6666u}) {
        const std::vector<Blobs> brick = {Blobs({32, 32, 32}, seed)};
        const LevelErrors e = rayErrors(raysOf(brick, {1, 1, 1}), {1}, table, info);
        for (int level = 1; level < kLevelCount; ++level) {
            const double truth = trueError(brick[0], level, table, info.spacingMm());
            const auto predicted = static_cast<double>(e.errors[0][static_cast<std::size_t>(level)]);
            EXPECT_GT(predicted, 0.5 * truth) << "seed " << seed << " level " << level;
            // Noise from voxel to voxel cancels less over 16 samples of a row than over its 32 voxels.
            EXPECT_LT(predicted, 2.5 * truth) << "seed " << seed << " level " << level;
        }
    }
}

// The visible part is the same at every level, but for the gradient, which coarser levels lose.
TEST(PredictErrors, KnowWhatOpacityByGradientLoses) {
    const VolumeInfo info = plainInfo({32, 32, 32}, ValueType::f32);
    TransferTable even = makeTable(TransferFunction::fromExtinction({{0, 0.05}}, {{0, {0.9, 0.6, 0.2}}}));
    const std::vector<Blobs> brick = {Blobs({32, 32, 32}, 44)};
    const BrickRays rays = raysOf(brick, {1, 1, 1});
    const LevelErrors none = rayErrors(rays, {1}, even, info);
    const float dense = none.transmittances[0];
    for (const float error : none.errors[0])
        EXPECT_LT(error, 1e-3f);
    even.gradientOpacity = GradientOpacity::fromPoints({{5, 0}, {60, 1}});
    const LevelErrors e = rayErrors(rays, {1}, even, info);
    EXPECT_GT(e.transmittances[0], dense + 0.05f);
    for (int level = 1; level < kLevelCount; ++level) {
        const double truth = trueError(brick[0], level, even, info.spacingMm());
        const auto predicted = static_cast<double>(e.errors[0][static_cast<std::size_t>(level)]);
        EXPECT_GT(predicted, 0.5 * truth) << "level " << level;
        EXPECT_LT(predicted, 2.5 * truth) << "level " << level; // as above
    }
}

TEST(BrickRays, SurviveTheirBytesAndTinyBricks) {
    for (const glm::ivec3 size :
         {glm::ivec3(1), glm::ivec3(1, 2, 1), glm::ivec3(32, 1, 3), glm::ivec3(7, 31, 32)}) {
        const Blobs b(size, 9);
        const BrickFields fields = b.fields();
        const auto parts = sampleRays(fields);
        const auto [lo, hi] = std::minmax_element(b.levels[0].begin(), b.levels[0].end());
        for (const BrickRayPart& part : parts) {
            std::array<std::uint8_t, kBrickRayBytes> bytes{};
            encode(part, bytes);
            const BrickRayPart back = decodeRays(bytes);
            EXPECT_EQ(back.codes, part.codes);
            EXPECT_EQ(back.axes, part.axes);
            EXPECT_EQ(back.lo, part.lo);
            EXPECT_EQ(back.hi, part.hi);
            EXPECT_GE(part.lo, *lo);
            EXPECT_LE(part.hi, *hi);
            EXPECT_EQ(back.axis(11), &part == parts.data() ? 0 : 1); // the extremes
            if (size == glm::ivec3(1)) {
                EXPECT_EQ(part.lo, b.levels[0][0]);
            }
        }
    }
}

TEST(BrickFields, AreTrilinearBetweenSampleCentres) {
    // A linear field is met exactly in the interior, whatever the level.
    std::array<std::vector<float>, kLevelCount> samples;
    BrickFields fields;
    fields.size = glm::ivec3(32);
    samples[0].resize(32 * 32 * 32);
    fields.voxels = samples[0];
    const auto value = [](const glm::dvec3& p) { return 3 * p.x - 2 * p.y + 0.5 * p.z; };
    for (int level = 1; level < kLevelCount; ++level) {
        const auto l = static_cast<std::size_t>(level);
        BrickFields::Box& box = fields.levels[l];
        box.first = glm::ivec3(-1);
        box.extent = glm::ivec3((32 >> level) + 2);
        samples[l].resize(cellCount(box.extent));
        for (int z = 0; z < box.extent.z; ++z)
            for (int y = 0; y < box.extent.y; ++y)
                for (int x = 0; x < box.extent.x; ++x)
                    samples[l][linearIndex({x, y, z}, box.extent)] = static_cast<float>(
                        value((glm::dvec3(x, y, z) - 0.5) * static_cast<double>(1 << level)));
        box.samples = samples[l];
        for (const glm::dvec3 p :
             {glm::dvec3(0), glm::dvec3(31.5, 0.25, 16), glm::dvec3(32), glm::dvec3(7.5, 20, 3)})
            EXPECT_NEAR(static_cast<double>(fields.at(level, p)), value(p), 1e-4) << level;
    }
}

} // namespace
} // namespace tessera
