// Selection: predicted errors against a slow computation, view weights against rays, budgets kept as pages
// cost them, and the choice against every possible choice where there are few.
#include "bricking/level_selection.h"

#include "bricking/visibility.h"
#include "bricking_test_volumes.h"
#include "core/colour.h"
#include "core/transfer_function.h"
#include "viewer/bench/hierarchy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>

namespace tessera {
namespace {
using test::mixed;
using test::plainInfo;

double uniform(std::uint64_t seed) {
    return static_cast<double>(mixed(seed * 0x9E3779B97F4A7C15u + 1) >> 11) * 0x1p-53;
}

/// Errors that fall with finer levels by random factors; every fifth brick shows nothing.
LevelErrors randomErrors(const glm::ivec3& bricks, std::uint64_t seed, bool withEmpty = true) {
    LevelErrors e;
    e.bricks = bricks;
    for (std::size_t b = 0; b < cellCount(bricks); ++b) {
        e.shows.push_back(withEmpty && mixed(seed + b) % 5 == 0 ? 0 : 1);
        std::array<float, kLevelCount> errors{};
        double error = 0;
        for (std::size_t level = 1; level < kLevelCount; ++level)
            errors[level] = static_cast<float>(error += 4 * uniform(seed + 100 * b + level));
        e.errors.push_back(e.shows.back() ? errors : std::array<float, kLevelCount>{});
    }
    return e;
}
ViewWeights plainWeights(const glm::ivec3& bricks, std::uint64_t seed) {
    ViewWeights w;
    w.bricks = bricks;
    w.pixels = 1000;
    for (std::size_t b = 0; b < cellCount(bricks); ++b) {
        w.area.push_back(static_cast<float>(uniform(seed + b)) * 100);
        w.finest.push_back(static_cast<std::uint8_t>(mixed(seed + b) % 3));
    }
    return w;
}
double weightedError(const Selection& s, const LevelErrors& e, const ViewWeights& w) {
    double sum = 0;
    for (std::size_t b = 0; b < s.levels.size(); ++b)
        if (s.levels[b] != Selection::kEmpty)
            sum += static_cast<double>(w.area[b]) * static_cast<double>(e.errors[b][s.levels[b]]);
    return sum;
}

// -- the choice
// ------------------------------------------------------------------------------------------------------------

TEST(SelectLevels, KeepsTheBudgetAndNothingFinerThanAPixelShows) {
    const glm::ivec3 bricks(13, 9, 7);
    const LevelErrors e = randomErrors(bricks, 1);
    const ViewWeights w = plainWeights(bricks, 2);
    const std::vector<float> means(e.shows.size(), 3.5f);
    double last = std::numeric_limits<double>::infinity();
    for (const std::size_t pages : {0, 1, 2, 3, 5, 8, 13, 50, 200, 100000}) {
        const Selection s = selectLevels(e, w, means, pages);
        EXPECT_LE(pagesOf(s), pages);
        std::array<std::size_t, kLevelCount + 1> counts{};
        for (std::size_t b = 0; b < s.levels.size(); ++b) {
            ++counts[s.levels[b]];
            EXPECT_EQ(s.levels[b] == Selection::kEmpty, e.shows[b] == 0);
            EXPECT_GE(s.levels[b], w.finest[b]);
        }
        EXPECT_EQ(counts, s.counts);
        EXPECT_EQ(s.means, means);
        EXPECT_EQ(s.bricks, bricks);
        std::size_t expected = 0;
        for (int level = 0; level < 5; ++level)
            expected += static_cast<std::size_t>(
                std::ceil(static_cast<double>(counts[static_cast<std::size_t>(level)]) / std::pow(8, level)));
        EXPECT_EQ(pagesOf(s), expected);
        EXPECT_LT(weightedError(s, e, w), last) << pages; // every one of these budgets buys something
        last = weightedError(s, e, w);
        for (const int threads : {1, 2, 7})
            EXPECT_EQ(selectLevels(e, w, means, pages, {}, threads).levels, s.levels);
        if (pages == 0) {
            EXPECT_EQ(s.counts[5] + s.counts[6], s.levels.size());
        }
        if (pages == 100000) {
            for (std::size_t b = 0; b < s.levels.size(); ++b)
                EXPECT_EQ(s.levels[b], e.shows[b] ? w.finest[b] : Selection::kEmpty);
        }
    }
}

/// Every combination of levels of five bricks that fits, against the greedy choice.
TEST(SelectLevels, IsCloseToTheBestOfAllChoices) {
    const glm::ivec3 bricks(5, 1, 1);
    double greedy = 0, best = 0, uniformLevel = 0;
    for (std::uint64_t trial = 0; trial < 60; ++trial) {
        const LevelErrors e = randomErrors(bricks, 1000 * trial, false);
        ViewWeights w = plainWeights(bricks, 77 * trial);
        std::fill(w.finest.begin(), w.finest.end(), std::uint8_t{0});
        const std::vector<float> means(5);
        const std::size_t pages = 1 + trial % 4;
        double least = std::numeric_limits<double>::infinity();
        for (int n = 0; n < 7776; ++n) {
            Selection s;
            int rest = n;
            for (int b = 0; b < 5; ++b, rest /= 6) {
                s.levels.push_back(static_cast<std::uint8_t>(rest % 6));
                ++s.counts[static_cast<std::size_t>(rest % 6)];
            }
            if (pagesOf(s) <= pages)
                least = std::min(least, weightedError(s, e, w));
        }
        const double ours = weightedError(selectLevels(e, w, means, pages), e, w);
        EXPECT_GE(ours, least - 1e-9);
        greedy += ours;
        best += least;
        uniformLevel += weightedError(selectUniform(e, means, pages), e, w);
    }
    EXPECT_LT(greedy, 1.05 * best); // five bricks, at most four pages: the hardest case for a greedy choice
    EXPECT_LT(greedy, uniformLevel);
}

TEST(SelectLevels, LeavesOutWhatTheViewAndTheFunctionDoNotNeed) {
    const glm::ivec3 bricks(4, 1, 1);
    LevelErrors e = randomErrors(bricks, 3, false);
    e.errors[2] = {}; // homogeneous: its mean is as good as its voxels
    ViewWeights w = plainWeights(bricks, 4);
    w.area = {100, 0, 100, 100};
    w.finest = {0, 0, 0, 1};
    const std::vector<float> means(4);
    const Selection s = selectLevels(e, w, means, 100);
    EXPECT_EQ(s.levels, (std::vector<std::uint8_t>{0, 5, 5, 1}));
    const std::vector<float> hidden = {0, 1, 1, 1};
    EXPECT_EQ(selectLevels(e, w, means, 100, hidden).levels, (std::vector<std::uint8_t>{5, 5, 5, 1}));
    // All that can be seen, however little it is predicted to matter.
    EXPECT_EQ(selectForError(e, w, means, 0).levels, (std::vector<std::uint8_t>{0, 5, 0, 1}));
}

TEST(SelectForError, MeetsTheErrorAndTakesNoMoreThanItNeeds) {
    const glm::ivec3 bricks(9, 8, 7);
    const LevelErrors e = randomErrors(bricks, 5);
    const ViewWeights w = plainWeights(bricks, 6);
    const std::vector<float> means(e.shows.size());
    std::size_t last = std::numeric_limits<std::size_t>::max();
    for (const double error : {0.0, 0.5, 1.0, 3.0, 8.0, 100.0}) {
        const Selection s = selectForError(e, w, means, error);
        const PredictedError predicted = predictError(s, e, w);
        EXPECT_LE(predicted.p99, error * (1 + 1e-9));
        EXPECT_GE(predicted.p99, error == 1.0 || error == 3.0 ? 0.5 * error : 0); // and uses what it may
        EXPECT_LE(predicted.mean, error);
        EXPECT_LE(pagesOf(s), last);
        last = pagesOf(s);
        if (error == 0.0) {
            EXPECT_EQ(predicted.mean, 0);
        }
    }
    EXPECT_EQ(last, 0u); // an error that every mean meets costs nothing
    const PredictedError coarse = predictError(selectLevels(e, w, means, 0), e, w);
    const PredictedError fine = predictError(selectLevels(e, w, means, 40), e, w);
    EXPECT_LT(fine.mean, coarse.mean);
    EXPECT_LE(fine.p99, coarse.p99);
    EXPECT_GT(coarse.p99, coarse.mean);
}

TEST(PredictError, IsThatOfItsModel) {
    LevelErrors e;
    e.bricks = {2, 1, 1};
    e.shows = {1, 1};
    e.errors = {{0, 1, 1, 1, 1, 2}, {0, 1, 1, 1, 1, 2}};
    ViewWeights w;
    w.area = {30, 10};
    w.finest = {0, 0};
    Selection s;
    s.levels = {5, 0};
    EXPECT_NEAR(predictError(s, e, w).mean, 0.75 * 2, 1e-12);
    EXPECT_NEAR(predictError(s, e, w).p99, 2 * std::log(75.0), 1e-6); // 0.75 exp(-x / 2) = 0.01
    const std::vector<float> visibility = {0.5f, 1.5f};
    EXPECT_NEAR(predictError(s, e, w, visibility).mean, 1, 1e-12);
    w.finest = {1, 0}; // what level 1 is off by cannot be seen
    EXPECT_NEAR(predictError(s, e, w).mean, 0.75 * std::sqrt(3.0), 1e-7);
    s.levels = {1, 0};
    EXPECT_EQ(predictError(s, e, w).p99, 0);
}

TEST(SelectUniform, TakesTheFinestLevelThatFits) {
    const LevelErrors e = randomErrors({10, 10, 1}, 7, false);
    const std::vector<float> means(100);
    EXPECT_EQ(selectUniform(e, means, 100).counts[0], 100u);
    EXPECT_EQ(selectUniform(e, means, 99).counts[1], 100u);
    EXPECT_EQ(selectUniform(e, means, 2).counts[2], 100u);
    EXPECT_EQ(selectUniform(e, means, 1).counts[3], 100u);
    EXPECT_EQ(selectUniform(e, means, 0).counts[5], 100u);
}

// -- visibility
// ------------------------------------------------------------------------------------------------------------

TEST(VisibilityFactors, RiseAtOnceFallSlowlyAndDoNotFlicker) {
    Selection s;
    s.levels = {0, 5, 0, 0};
    const std::vector<SeenBrick> seen = {{25600, 100}, {0, 0}, {9, 100}, {3200, 100}},
                                 hidden(4, SeenBrick{0, 7}),
                                 jitter = {{20000, 100}, {15000, 100}, {0, 100}, {4000, 100}};
    const auto first = visibilityFactors(seen, s);
    EXPECT_EQ(first, (std::vector<float>{1, 1, kHiddenVisibility, 0.125f}));
    EXPECT_EQ(visibilityFactors(jitter, s, first), first);
    const auto next = visibilityFactors(hidden, s, first);
    EXPECT_EQ(next, (std::vector<float>{0.5f, kHiddenVisibility, kHiddenVisibility, 0.0625f}));
    auto later = next;
    for (int n = 0; n < 7; ++n)
        later = visibilityFactors(hidden, s, later);
    for (const float f : later)
        EXPECT_LE(f, 2 * kHiddenVisibility); // the dead band ends where hidden begins
    EXPECT_EQ(visibilityFactors(seen, s, later)[0], 1);
    EXPECT_EQ(visibilityFactors(std::vector<SeenBrick>(4, {UINT32_MAX, 1}), s)[0], 1);
}

// -- the view
// ------------------------------------------------------------------------------------------------------------

VolumeInfo shearedInfo() {
    VolumeInfo info = plainInfo({150, 100, 75}, ValueType::i16);
    info.patientFromVoxel =
        patientFromVoxelOf({-60, -40, -30}, {0.9, 0.1, 0}, {-0.2, 0.8, 0.1}, {0.3, 0, 1.4});
    return info;
}

/// Pixels whose ray meets a brick: 16 rays a pixel, jittered, because edges may lie along the grid.
std::vector<double> areasByRays(const Camera& camera, const VolumeInfo& info, const glm::ivec2& size) {
    const glm::ivec3 bricks = brickGrid(info.extentVoxels);
    std::vector<double> areas(cellCount(bricks));
    const RayPlane plane = rayPlane(camera, info, size);
    const glm::dmat4 voxelFromPatient = glm::inverse(info.patientFromVoxel);
    constexpr int kFine = 4;
    for (int y = 0; y < kFine * size.y; ++y)
        for (int x = 0; x < kFine * size.x; ++x) {
            const std::uint64_t seed = 2 * static_cast<std::uint64_t>(y * kFine * size.x + x);
            const PatientRay ray =
                pixelRay(plane, {(x + uniform(seed)) / kFine, (y + uniform(seed + 1)) / kFine}, size);
            const glm::dvec3 base(voxelFromPatient * glm::dvec4(ray.base, 1));
            const glm::dvec3 along(glm::dmat3(voxelFromPatient) * ray.direction);
            for (int k = 0; k < bricks.z; ++k)
                for (int j = 0; j < bricks.y; ++j)
                    for (int i = 0; i < bricks.x; ++i) {
                        double near = ray.minT, far = std::numeric_limits<double>::infinity();
                        const glm::ivec3 first = glm::ivec3(i, j, k) * 32;
                        const glm::ivec3 end = glm::min(first + 32, info.extentVoxels);
                        for (int axis = 0; axis < 3; ++axis) {
                            const double a = (first[axis] - base[axis]) / along[axis],
                                         b = (end[axis] - base[axis]) / along[axis];
                            near = std::max(near, std::min(a, b));
                            far = std::min(far, std::max(a, b));
                        }
                        if (near < far)
                            areas[linearIndex({i, j, k}, bricks)] += 1.0 / (kFine * kFine);
                    }
        }
    return areas;
}

TEST(ViewWeights, AreasAreThoseThatRaysFind) {
    const VolumeInfo info = shearedInfo();
    const glm::ivec2 size(61, 43);
    const glm::dvec3 middle(info.patientFromVoxel * glm::dvec4(70.3, 41.7, 33.1, 1));
    std::vector<Camera> cameras = {fitCamera(info, ::tessera::View::anterior, Projection::perspective, size),
                                   fitCamera(info, ::tessera::View::left, Projection::parallel, size)};
    for (const double angle : {30.0, 130.0, 170.0}) {
        Camera inside;
        inside.position = middle;
        inside.focalPoint = middle + glm::dvec3(1, 0.4, 0.2);
        inside.viewAngle = angle;
        cameras.push_back(inside);
    }
    Camera close = cameras[0];
    close.focalPoint += glm::dvec3(40, 0, 30);
    close.viewAngle = 12;
    cameras.push_back(close); // most of the volume outside
    Camera away = cameras[0];
    away.focalPoint = 2.0 * away.position - away.focalPoint;
    cameras.push_back(away);
    for (std::size_t n = 0; n < cameras.size(); ++n) {
        const ViewWeights w = viewWeights(cameras[n], info, size);
        const std::vector<double> expected = areasByRays(cameras[n], info, size);
        ASSERT_EQ(w.area.size(), expected.size());
        EXPECT_EQ(w.pixels, 61 * 43);
        std::size_t seen = 0;
        for (std::size_t b = 0; b < expected.size(); ++b) {
            const double area = static_cast<double>(w.area[b]);
            if (expected[b] > 0) {
                // What 16 rays a pixel leave uncertain along the outline.
                EXPECT_NEAR(area, expected[b], 0.5 + 0.05 * expected[b]) << "camera " << n << " brick " << b;
                ++seen;
            }
            EXPECT_LE(area, w.pixels);
            EXPECT_GE(area, 0);
            for (const int threads : {1, 3})
                ASSERT_EQ(viewWeights(cameras[n], info, size, threads).area[b], w.area[b]);
        }
        if (n + 1 == cameras.size()) {
            EXPECT_EQ(seen, 0u);
            for (const float area : w.area)
                EXPECT_EQ(area, 0); // looking away: nothing, not even by blending
        } else {
            EXPECT_GT(seen, 0u);
        }
    }
}

TEST(ViewWeights, FinestLevelIsWhatAPixelShows) {
    VolumeInfo info = plainInfo({320, 32, 32}, ValueType::i16);
    info.patientFromVoxel = patientFromVoxelOf({0.5, 0.5, 0.5}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1});
    Camera parallel;
    parallel.projection = Projection::parallel;
    parallel.position = {160, -1000, 16};
    parallel.focalPoint = {160, 0, 16};
    parallel.parallelScale = 200; // 100 pixels over 400 mm: 4 mm a pixel
    for (const std::uint8_t level : viewWeights(parallel, info, {100, 100}).finest)
        EXPECT_EQ(level, 2);
    parallel.parallelScale = 199.9; // a hair less than 4 mm
    for (const std::uint8_t level : viewWeights(parallel, info, {100, 100}).finest)
        EXPECT_EQ(level, 1);
    parallel.parallelScale = 1e5;
    for (const std::uint8_t level : viewWeights(parallel, info, {100, 100}).finest)
        EXPECT_EQ(level, 5);

    // Looking along x from the front face: a pixel grows with the distance; 2 tan(45) / 200 mm per mm.
    Camera ahead;
    ahead.position = {-100, 16, 16};
    ahead.focalPoint = {100, 16, 16};
    ahead.viewAngle = 90;
    const ViewWeights w = viewWeights(ahead, info, {200, 200});
    for (int i = 0; i < 10; ++i) {
        const double depth = 100 + 32.0 * i, pixel = depth / 100;
        const double tangent = 16 * std::sqrt(2.0) / depth; // the nearest corners
        const double across = pixel / std::sqrt(1 + tangent * tangent);
        EXPECT_EQ(w.finest[static_cast<std::size_t>(i)],
                  std::max(0, static_cast<int>(std::floor(std::log2(across)))))
            << i;
    }
    // Inside, all that is beside or behind is as fine as it can be.
    Camera inside = ahead;
    inside.position = {100, 16, 16};
    inside.focalPoint = {200, 16, 16};
    inside.viewAngle = 130;
    const ViewWeights near = viewWeights(inside, info, {200, 200});
    EXPECT_EQ(near.finest[3], 0);
    EXPECT_EQ(near.area[3], 200 * 200);
    EXPECT_EQ(near.area[0], 0); // behind
    EXPECT_GT(near.finest[9], 0);
}

// -- predicted errors
// ------------------------------------------------------------------------------------------------------------

/// A brick of random blobs with its coarser levels by plain averaging; no neighbours.
struct Blobs {
    glm::ivec3 size;
    std::array<glm::ivec3, kLevelCount> extents;
    std::array<std::vector<float>, kLevelCount> levels;

    Blobs(const glm::ivec3& n, std::uint64_t seed) : size(n) {
        for (int level = 0; level < kLevelCount; ++level) {
            const auto at = static_cast<std::size_t>(level);
            const glm::ivec3 e = extents[at] = levelExtent(n, level);
            levels[at].resize(cellCount(e));
            for (int z = 0; z < e.z; ++z)
                for (int y = 0; y < e.y; ++y)
                    for (int x = 0; x < e.x; ++x) {
                        float& out = levels[at][linearIndex({x, y, z}, e)];
                        if (level == 0) {
                            const double phase = uniform(seed) * 6;
                            out = static_cast<float>(100 * std::sin(0.3 * x + phase) *
                                                         std::cos(0.2 * y + 0.1 * z) +
                                                     40 * uniform(seed + linearIndex({x, y, z}, e)));
                            continue;
                        }
                        const glm::ivec3 f = extents[at - 1];
                        double sum = 0;
                        for (int c = 0; c < 8; ++c)
                            sum += static_cast<double>(levels[at - 1][linearIndex(
                                glm::min(2 * glm::ivec3(x, y, z) + glm::ivec3(c & 1, c >> 1 & 1, c >> 2),
                                         f - 1),
                                f)]);
                        out = static_cast<float>(sum / 8);
                    }
        }
    }
    BrickFields fields() const {
        BrickFields out;
        out.size = size;
        out.voxels = levels[0];
        for (std::size_t level = 1; level < kLevelCount; ++level)
            out.levels[level] = {glm::ivec3(0), extents[level], levels[level]};
        return out;
    }
};

TransferTable testTable() {
    return makeTable(
        TransferFunction::fromOpacity({{-20, 0}, {30, 0.08}, {60, 0}, {80, 0.5}},
                                      {{-20, {1, 0.2, 0.1}}, {50, {0.2, 0.9, 0.3}}, {100, {1, 1, 1}}}, 1));
}

BrickRays raysOf(const std::vector<Blobs>& bricks, const glm::ivec3& grid) {
    BrickRays rays;
    rays.bricks = grid;
    rays.pages.emplace_back(BrickRays::kRowsPerPage * rays.rowBytes());
    for (const Blobs& b : bricks) {
        const auto parts = sampleRays(b.fields());
        const auto row = rays.row(static_cast<std::uint32_t>(rays.rows));
        for (std::size_t part = 0; part < parts.size(); ++part)
            encode(parts[part], std::span<std::uint8_t, kBrickRayBytes>(row.data() + part * kBrickRayBytes,
                                                                        kBrickRayBytes));
        rays.rowOf.push_back(static_cast<std::uint32_t>(rays.rows++));
    }
    return rays;
}

/// The definition in level_error.h, from the codes, in double, without tables.
double slowError(const BrickRays& rays, std::uint32_t row, int level, const TransferTable& table,
                 const VolumeInfo& info, const glm::ivec3& size) {
    const auto coloured = [&](const BrickRayPart& part, int ray, int at) {
        std::size_t code = static_cast<std::size_t>(ray * kSamplesPerRay);
        for (int l = 0; l < at; ++l)
            code += static_cast<std::size_t>(kRaySamples[static_cast<std::size_t>(l)]);
        const int samples = kRaySamples[static_cast<std::size_t>(at)], axis = part.axis(ray);
        glm::dvec3 colour(0);
        double through = 1;
        for (int j = 0; j < samples; ++j) {
            const double stored =
                static_cast<double>(part.lo) +
                (static_cast<double>(part.hi) - static_cast<double>(part.lo)) * part.codes[code++] / 255;
            const double value = info.rescaleSlope * stored + info.rescaleIntercept;
            const double entry = std::clamp((value - static_cast<double>(table.firstValue)) *
                                                static_cast<double>(table.entriesPerValue),
                                            0.0, static_cast<double>(table.entries.size() - 1));
            const auto left = std::min(static_cast<std::size_t>(entry), table.entries.size() - 2);
            const glm::dvec4 e =
                glm::mix(glm::dvec4(table.entries[left]), glm::dvec4(table.entries[left + 1]),
                         entry - static_cast<double>(left));
            const double alpha = -std::expm1(-e.a * info.spacingMm()[axis] * size[axis] / samples);
            colour += through * alpha * glm::dvec3(e);
            through *= 1 - alpha;
        }
        return luvFromLinear(colour);
    };
    double sum = 0;
    for (int p = 0; p < kBrickRayParts; ++p) {
        const BrickRayPart part = decodeRays(rays.part(row, p));
        for (int ray = 0; ray < kRaysPerPart; ++ray)
            sum += (ray < 7 ? 15.0 / 16 / 7 : 1.0 / 16) / 2 *
                   glm::length(coloured(part, ray, level) - coloured(part, ray, 0));
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
    const double a[6] = {0, 0.8, 1.6, 2.4, 3.2, 6}, b[6] = {0, 0.2, 0.4, 0.6, 0.8, 9}; // a fifth of the other
    for (std::size_t level = 1; level < kLevelCount; ++level) {
        const double share = (a[level] + b[level]) / 25;
        EXPECT_NEAR(static_cast<double>(e.errors[0][level]), 0.5 * a[level] + 0.5 * 14 * share, 1e-5);
        EXPECT_NEAR(static_cast<double>(e.errors[1][level]), 0.5 * b[level] + 0.5 * 11 * share, 1e-5);
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
                        const double alpha = -std::expm1(-e.a * spacing[axis]);
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
            // Noise from voxel to voxel cancels less over 8 samples of a row than over its 32 voxels.
            EXPECT_LT(predicted, 2.5 * truth) << "seed " << seed << " level " << level;
        }
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
            EXPECT_EQ(back.axis(7), &part == parts.data() ? 0 : 1); // the extremes
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

// -- hierarchies, for comparison
// ------------------------------------------------------------------------------------------------------------

using bench::BlockGrid;
using bench::Need;

TEST(Hierarchy, CostsWhatAHandCounts) {
    // 8x8 blocks of 8x8 samples: one boundary block in a corner, one interior block in the opposite one.
    BlockGrid grid{2, {8, 8, 1}, 8, std::vector<Need>(64, Need::outside)};
    grid.needs[0] = Need::boundary;
    grid.needs[63] = Need::interior;
    const auto flat = bench::flatCost(grid);
    EXPECT_EQ(flat.samples, 62u + 64u + 4u);
    EXPECT_EQ(flat.ignored, 62u);
    // All children: 3 of depth 1 (one interior, two outside), 3 of depth 2, 4 of depth 3.
    const auto all = bench::hierarchyCost(grid, true);
    EXPECT_EQ(all.levels[0].blocks, 0u);
    EXPECT_EQ(all.levels[1].blocks, 3u);
    EXPECT_EQ(all.levels[2].blocks, 3u);
    EXPECT_EQ(all.levels[3].blocks, 4u);
    EXPECT_EQ(all.samples, 640u);
    EXPECT_EQ(all.ignored, 64u * 8);
    // Partly: the root stays, one node of each depth on the way to the corner, and the interior's.
    const auto part = bench::hierarchyCost(grid, false);
    EXPECT_EQ(part.levels[0].blocks, 1u);
    EXPECT_EQ(part.levels[1].blocks, 2u);
    EXPECT_EQ(part.levels[2].blocks, 1u);
    EXPECT_EQ(part.levels[3].blocks, 1u);
    EXPECT_EQ(part.ignored, 0u);
    EXPECT_EQ(bench::fullSamples(grid), 4096u);
    // Where every block is at the boundary all schemes cost the same.
    grid.needs.assign(64, Need::boundary);
    for (const auto& cost :
         {bench::flatCost(grid), bench::hierarchyCost(grid, true), bench::hierarchyCost(grid, false)})
        EXPECT_EQ(cost.samples, 4096u);
}

/// The printed table, all three schemes.
TEST(Hierarchy, Table21) {
    const BlockGrid grid = bench::table21Grid();
    const auto expectBlocks = [](const bench::SelectionCost& cost, std::array<std::size_t, 4> blocks,
                                 std::size_t samples) {
        for (std::size_t level = 0; level < 4; ++level)
            EXPECT_EQ(cost.levels[level].blocks, blocks[level]) << level;
        EXPECT_EQ(cost.samples, samples);
    };
    expectBlocks(bench::hierarchyCost(grid, true), {0, 1, 3, 36}, 2560);
    expectBlocks(bench::hierarchyCost(grid, false), {1, 3, 9, 22}, 2240);
    expectBlocks(bench::flatCost(grid), {38, 4, 0, 22}, 1462);
}

TEST(Hierarchy, FlatNeverNeedsMore) {
    for (std::uint64_t trial = 0; trial < 200; ++trial) {
        const int dimensions = trial % 2 == 0 ? 2 : 3;
        const glm::ivec3 blocks(1 + static_cast<int>(mixed(trial) % 19),
                                1 + static_cast<int>(mixed(trial + 999) % 11),
                                dimensions == 3 ? 1 + static_cast<int>(mixed(trial + 99) % 9) : 1);
        BlockGrid grid{dimensions, blocks, 8, {}};
        for (std::size_t b = 0; b < cellCount(blocks); ++b)
            grid.needs.push_back(static_cast<Need>(mixed(trial * 7919 + b / (1 + trial % 5)) % 3));
        const auto flat = bench::flatCost(grid);
        for (const bool allChildren : {true, false}) {
            const auto tree = bench::hierarchyCost(grid, allChildren);
            EXPECT_LE(flat.samples - flat.ignored, tree.samples - tree.ignored);
        }
    }
}

} // namespace
} // namespace tessera
