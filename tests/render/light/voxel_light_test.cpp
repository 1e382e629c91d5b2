// tests/render/light/voxel_light_test.cpp: light per voxel, texel by texel, from its inputs: the runs of
// samples that show something, and every brick's texels as docs/sampling.md has them. On volumes of three
// unlike extents, with several chunks along each axis.
#include "render/contract/leaves.h"
#include "render/light/directions.h"
#include "render/light/histogram_light.h"
#include "render/light/occlusion.h"
#include "render/light/scene_light.h"
#include "tests/support/mixed_fixture.h"
#include "tests/support/surface_fixture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <glm/common.hpp>
#include <gtest/gtest.h>
#include <memory>
#include <set>
#include <string>
#include <tuple>
#include <vector>

namespace tessera::test {
namespace {

const glm::ivec3 kLitExtent(70, 75, 100);
constexpr int kRun = native::kOcclusionRun;
const std::vector<glm::ivec3> kSpots = {{3, 40, 9}, {66, 2, 77}, {33, 31, 96}, {12, 74, 63}, {69, 50, 30}};

// docs/sampling.md: texel / 16384, at most 65535, rounded; no number is dark.
TEST(LightTexel, IsRoundedAndHeld) {
    EXPECT_EQ(lightTexel(0), 0);
    EXPECT_EQ(lightTexel(1), 16384);
    EXPECT_EQ(lightTexel(0.25f), 4096);
    EXPECT_EQ(lightTexel(4096.25f / 16384), 4096);
    EXPECT_EQ(lightTexel(4096.75f / 16384), 4097);
    EXPECT_EQ(lightTexel(3.75f), 61440);
    EXPECT_EQ(lightTexel(4), 65535);
    EXPECT_EQ(lightTexel(1e9f), 65535);
    EXPECT_EQ(lightTexel(-0.5f), 0);
    EXPECT_EQ(lightTexel(std::nanf("")), 0);
}

/// True if a box of voxels, its ends included, holds a place of those that are 1 for a formula of spots.
bool meets(const glm::ivec3& low, const glm::ivec3& high, int around) {
    return std::any_of(kSpots.begin(), kSpots.end(), [&](const glm::ivec3& spot) {
        return glm::all(glm::lessThanEqual(low - around, spot)) &&
               glm::all(glm::lessThanEqual(spot, high + around));
    });
}

/// Light is computed where something shows within two samples, and nowhere else: at level 0 by values,
/// elsewhere by the cells of 8 voxels, or bricks of 32, that lie within two samples, each with a voxel around
/// it.
TEST(Occluder, FindsTheRunsThatShowNear) {
    const Stored stored(
        [](const glm::dvec3& p) {
            return std::count(kSpots.begin(), kSpots.end(), glm::ivec3(p)) > 0 ? 1.0 : 0.0;
        },
        kLitExtent, true);
    Scene scene = stored.scene({});
    scene.volumes[0].transferFunction = TransferFunction::fromExtinction({{0.5, 0}, {1, 1}}, {});
    const auto prepared = stored.prepare(scene);
    const Planner& p = prepared->p;
    Occluder occluder(p.info(), p.layer().statistics, std::nullopt);
    occluder.setFunction(p.layer().table, p.layer().optics);
    OcclusionRoom room(glm::ivec3(5, 3, 4));
    std::size_t found = 0, all = 0;
    for (int level = 0; level < kLevelCount; ++level) {
        const glm::ivec3 extent = levelExtent(kLitExtent, level), chunks = chunkGrid(kLitExtent, level);
        const int unit = level == 0 ? 1 : level < 3 ? kCellExtent : kBrickExtent;
        const auto shows = [&](const glm::ivec3& first) {
            const glm::ivec3 low = glm::max(first - 2, glm::ivec3(0)) << level;
            const glm::ivec3 high = glm::min((first + glm::ivec3(kRun, 1, 1) + 2) << level, kLitExtent) - 1;
            return meets(low / unit * unit, high / unit * unit + unit - 1, level == 0 ? 0 : 1);
        };
        for (std::size_t c = 0; c < cellCount(chunks); ++c) {
            const glm::ivec3 at = gridPosition(c, chunks), corner = at * kChunkExtent;
            // All bricks, then every third one.
            const int along = 1 << level, edge = kBrickExtent >> level;
            std::vector<std::uint8_t> some(cellCount(glm::ivec3(along)), 0);
            for (std::size_t b = 0; b < some.size(); ++b)
                some[b] = b % 3 == 1 ? 1 : 0;
            for (const bool isSome : {false, true}) {
                occluder.find({level, at.x, at.y, at.z}, isSome ? some : std::vector<std::uint8_t>(), false,
                              *p.layer().cache, room);
                std::set<std::tuple<int, int, int>> expected, runs;
                for (int z = 0; z < kChunkExtent; ++z)
                    for (int y = 0; y < kChunkExtent; ++y)
                        for (int x = 0; x < kChunkExtent; x += kRun) {
                            const glm::ivec3 in(x, y, z);
                            bool wanted = !isSome;
                            for (int n = 0; n < kRun && isSome; ++n)
                                wanted =
                                    wanted ||
                                    some[linearIndex((in + glm::ivec3(n, 0, 0)) / edge, glm::ivec3(along))] !=
                                        0;
                            if (wanted && glm::all(glm::lessThan(corner + in, extent)) && shows(corner + in))
                                expected.insert({x, y, z});
                        }
                for (const OcclusionRoom::Run& run : room.runs) {
                    runs.insert({run.at.x, run.at.y, run.at.z});
                    ASSERT_EQ(run.to, linearIndex(run.at, glm::ivec3(kChunkExtent)));
                    ASSERT_EQ(run.from, linearIndex(run.at + room.reach, room.size));
                }
                ASSERT_EQ(runs.size(), room.runs.size());
                ASSERT_EQ(runs, expected)
                    << "level " << level << ", chunk " << c << (isSome ? ", some bricks" : "");
                found += runs.size();
                all += kChunkExtent * kChunkExtent * kChunkExtent / kRun;
            }
        }
    }
    EXPECT_GT(found, 100u);
    EXPECT_LT(found, all / 2);
}

/// Texels of a level, or what stands for them between: x fastest.
struct LevelTexels {
    glm::ivec3 extent{0};
    std::vector<double> texels;
    double at(const glm::ivec3& i) const { return texels[linearIndex(i, extent)]; }
    /// Trilinear, clamped to the outermost samples. @param place  samples, the first one's centre at 0
    double between(const glm::dvec3& place) const {
        const glm::dvec3 in = glm::clamp(place, glm::dvec3(0), glm::dvec3(extent - 1));
        const glm::ivec3 low(in);
        double sum = 0;
        for (int n = 0; n < 8; ++n) {
            const glm::ivec3 corner(n & 1, n >> 1 & 1, n >> 2);
            const glm::dvec3 f = in - glm::dvec3(low);
            double weight = 1;
            for (int axis = 0; axis < 3; ++axis)
                weight *= corner[axis] != 0 ? f[axis] : 1 - f[axis];
            sum += weight == 0 ? 0 : weight * at(glm::min(low + corner, extent - 1));
        }
        return sum;
    }
};

using TexelOf = std::function<double(int level, const glm::ivec3& sample)>;

/// All levels from one on.
std::vector<LevelTexels> levelsOf(const TexelOf& texel, int finest) {
    std::vector<LevelTexels> levels(kLevelCount);
    for (int level = finest; level < kLevelCount; ++level) {
        LevelTexels& of = levels[static_cast<std::size_t>(level)];
        of.extent = levelExtent(kLitExtent, level);
        for (std::size_t n = 0; n < cellCount(of.extent); ++n)
            of.texels.push_back(texel(level, gridPosition(n, of.extent)));
    }
    return levels;
}

/// Light of bricks of mixed levels: what the test's volume, function and lights make of each texel.
struct LitBricks {
    LitBricks(const Lighting& lighting, int bricksAt)
        : stored([](const glm::dvec3& p) { return p.x + 0.5 * p.y + 2 * p.z; }, kLitExtent) {
        Scene scene = stored.scene({});
        // Thin where it begins, and so thick at last that light and shade differ from place to place.
        scene.volumes[0].transferFunction =
            TransferFunction::fromExtinction({{90, 0}, {100, 0.004}, {340, 0.5}}, {{0, {0.9, 0.4, 0.2}}});
        scene.lighting = lighting;
        prepared = stored.prepare(scene);
        Planner& p = prepared->p;
        p.view.shadowQuality.mapSize = 32;
        Selection selection = randomShownLevels(p.layer().selection, 7);
        if (bricksAt >= 0)
            for (std::uint8_t& level : selection.levels)
                level = level == Selection::kEmpty ? level : static_cast<std::uint8_t>(bricksAt);
        selection.counts = {};
        for (const std::uint8_t level : selection.levels)
            ++selection.counts[level];
        p.setSelection(selection);
        p.mapLevels(true);
        light = std::make_unique<SceneLight>(p, 2);
        texels = std::make_unique<StoredLight>(*light, p, prepared->budgets.ram);
    }
    /// Every texel of a channel.
    /// @param finest  level of the channel's light
    void expectChannel(int channel, const TexelOf& texel, int finest, const std::string& what) const {
        const Selection& selection = prepared->p.layer().selection;
        const std::vector<LevelTexels> levels = levelsOf(texel, finest);
        const StoredLight::Channel found(*texels, channel);
        double least = 1e9, most = 0;
        for (std::size_t b = 0; b < selection.levels.size(); ++b) {
            const glm::ivec3 brick = gridPosition(b, selection.bricks);
            const int level = selection.levels[b];
            ASSERT_EQ(found.isEmpty(brick), level == Selection::kEmpty);
            if (level >= kLevelCount - 1) {
                ASSERT_NEAR(found.mean(brick), levels[kLevelCount - 1].at(brick), 1)
                    << what << ", brick " << b;
                continue;
            }
            const int own = std::max(level, finest), edge = kBrickExtent >> level;
            const LevelTexels& from = levels[static_cast<std::size_t>(own)];
            const glm::ivec3 end = glm::min(glm::ivec3(edge), levelExtent(kLitExtent, level) - brick * edge);
            for (std::size_t n = 0; n < cellCount(end); ++n) {
                const glm::ivec3 i = brick * edge + gridPosition(n, end);
                const double expected =
                    from.between((glm::dvec3(i) + 0.5) * std::ldexp(1.0, level - own) - 0.5);
                ASSERT_NEAR(found.at(level, i), expected, own == level ? 1 : 1.5)
                    << what << ", level " << level << ", light of " << own << ", at " << i.x << "," << i.y
                    << "," << i.z;
                least = std::min(least, expected), most = std::max(most, expected);
            }
        }
        EXPECT_LT(least, 0.95 * most) << what; // else nothing was compared
    }
    const Planner& p() const { return prepared->p; }
    glm::dvec3 placeOf(int level, const glm::ivec3& sample) const {
        return glm::dvec3(p().info().patientFromVoxel *
                          glm::dvec4((glm::dvec3(sample) + 0.5) * std::ldexp(1.0, level), 1));
    }
    /// Of a light that casts a shadow; 1 where no light is computed.
    TexelOf shadow(std::size_t caster) const {
        return [this, caster, runs = runsOf()](int level, const glm::ivec3& sample) {
            return runs(level, sample) ? static_cast<double>(lightTexel(
                                             light->shadows()[caster].light(placeOf(level, sample), level)))
                                       : 16384.0;
        };
    }
    /// Whether a sample is in a run that Occluder::find() names.
    std::function<bool(int, const glm::ivec3&)> runsOf() const {
        auto lit = std::make_shared<std::array<std::vector<std::uint8_t>, kLevelCount>>();
        Occluder occluder(p().info(), p().layer().statistics, std::nullopt);
        occluder.setFunction(p().layer().table, p().layer().optics);
        OcclusionRoom room(glm::ivec3(2));
        for (int level = 0; level < kLevelCount; ++level) {
            const glm::ivec3 extent = levelExtent(kLitExtent, level), chunks = chunkGrid(kLitExtent, level);
            std::vector<std::uint8_t>& of = (*lit)[static_cast<std::size_t>(level)];
            of.assign(cellCount(extent), 0);
            for (std::size_t c = 0; c < cellCount(chunks); ++c) {
                const glm::ivec3 at = gridPosition(c, chunks);
                occluder.find({level, at.x, at.y, at.z}, {}, false, *p().layer().cache, room);
                for (const OcclusionRoom::Run& run : room.runs)
                    for (int n = 0; n < kRun; ++n) {
                        const glm::ivec3 i = at * kChunkExtent + run.at + glm::ivec3(n, 0, 0);
                        if (glm::all(glm::lessThan(i, extent)))
                            of[linearIndex(i, extent)] = 1;
                    }
            }
        }
        return [lit](int level, const glm::ivec3& i) {
            return (*lit)[static_cast<std::size_t>(level)][linearIndex(i, levelExtent(kLitExtent, level))] !=
                   0;
        };
    }
    Stored stored;
    std::unique_ptr<Prepared> prepared;
    std::unique_ptr<SceneLight> light;
    std::unique_ptr<StoredLight> texels;
};

Light sun(const glm::dvec3& direction) {
    Light light;
    light.kind = LightKind::directional;
    light.frame = LightFrame::patient;
    light.direction = direction;
    light.shadow = true;
    return light;
}

/// Shadows of two lights, and occlusion by few rays, at the bricks' own levels and at coarser ones.
TEST(VoxelLight, IsThatOfEverySample) {
    for (const int finest : {0, 1, 3}) {
        Lighting lighting;
        lighting.lights = {sun({0.3, -0.5, 1}), sun({-1, 0.2, 0.1})};
        lighting.occlusion = Occlusion{.rays = 4, .radiusMm = 5, .bias = 0.2, .gamma = 0.5};
        lighting.finestLevel = finest;
        const LitBricks lit(lighting, finest == 1 ? 0 : -1);
        const std::string what = "finest level " + std::to_string(finest);
        lit.expectChannel(1, lit.shadow(0), finest, what + ", first light");
        lit.expectChannel(2, lit.shadow(1), finest, what + ", second light");
        // Occlusion of every sample of every chunk, which tests of Occluder compare with the contract.
        const Occlusion& occlusion = *lighting.occlusion;
        Occluder occluder(lit.p().info(), lit.p().layer().statistics, occlusion);
        occluder.setFunction(lit.p().layer().table, lit.p().layer().optics);
        OcclusionRoom room(occluder.mostReach());
        std::vector<LevelTexels> levels(kLevelCount);
        for (int level = finest; level < kLevelCount; ++level) {
            LevelTexels& of = levels[static_cast<std::size_t>(level)];
            of.extent = levelExtent(kLitExtent, level);
            of.texels.assign(cellCount(of.extent), 16384.0);
            const glm::ivec3 chunks = chunkGrid(kLitExtent, level);
            for (std::size_t c = 0; c < cellCount(chunks); ++c) {
                const glm::ivec3 at = gridPosition(c, chunks);
                const ChunkKey key{level, at.x, at.y, at.z};
                occluder.find(key, {}, true, *lit.p().layer().cache, room);
                occluder.occlude(key, room);
                for (const OcclusionRoom::Run& run : room.runs)
                    for (int n = 0; n < kRun; ++n) {
                        const glm::ivec3 in = run.at + glm::ivec3(n, 0, 0), i = at * kChunkExtent + in;
                        if (glm::all(glm::lessThan(i, of.extent))) {
                            const double left = room.light[linearIndex(in, glm::ivec3(kChunkExtent))];
                            of.texels[linearIndex(i, of.extent)] =
                                std::floor(16384 * std::pow(0.2 + left, 0.5) + 0.5);
                        }
                    }
            }
        }
        lit.expectChannel(
            0, [&](int level, const glm::ivec3& i) { return levels[static_cast<std::size_t>(level)].at(i); },
            finest, what + ", occlusion");
    }
}

/// By histograms: each sample has its representative's light, a coarser one the mean over those that it
/// stands for; shadows keep their own finest level.
TEST(VoxelLight, ByHistogramsIsThatOfEverySample) {
    Lighting lighting;
    lighting.lights = {sun({0.3, -0.5, 1})};
    lighting.occlusion = Occlusion{
        .method = OcclusionMethod::histogram, .radiusMm = 6, .bias = 0.2, .gamma = 0.5, .bleeding = 0.7};
    const LitBricks lit(lighting, -1);
    const Layer& layer = lit.p().layer();
    const LocalHistograms& histograms = *layer.histograms;
    ASSERT_GT(histograms.level, 0);
    HistogramLight source(lit.p().info(), histograms, *lighting.occlusion);
    source.functionChanged(layer.table, layer.optics);
    const auto runs = lit.runsOf();
    for (int channel = 0; channel < 3; ++channel) {
        const auto texel = [&](int level, const glm::ivec3& sample) {
            if (!runs(level, sample))
                return 16384.0;
            const int shift = level - histograms.level;
            double open = 0, colour = 0, count = 0;
            for (int n = 0; n < 1 << (3 * shift); ++n) {
                const glm::ivec3 i =
                    (sample << shift) + gridPosition(static_cast<std::size_t>(n), glm::ivec3(1 << shift));
                if (!glm::all(glm::lessThan(i, histograms.extent)))
                    continue;
                const HistogramLight::Row& row =
                    source.rows()[histograms.numbers[linearIndex(i, histograms.extent)]];
                open += row.open, colour += row.colour[channel], ++count;
            }
            return std::floor(16384 * std::pow(0.2 + (open + colour) / count, 0.5) + 0.5);
        };
        lit.expectChannel(channel, texel, histograms.level, "histograms, channel " + std::to_string(channel));
    }
    lit.expectChannel(3, lit.shadow(0), 0, "the shadow beside");
}

/// Where shadows of another volume fall on it, a texel is the product of both shares.
TEST(VoxelLight, ShadowsOfOthersMultiply) {
    Lighting lighting;
    lighting.lights = {sun({0.3, -0.5, 1}), sun({-1, 0.2, 0.1})};
    const LitBricks lit(lighting, 0);
    VoxelLight& voxels = lit.light->voxels();
    std::vector<ShadowMaps> turned = {lit.light->shadows()[1], lit.light->shadows()[0]};
    voxels.setOtherShadows({std::span<const ShadowMaps>(turned)});
    const glm::ivec3 bricks = brickGrid(kLitExtent);
    const auto runs = lit.runsOf();
    const std::size_t b = linearIndex({1, 0, 2}, bricks);
    std::size_t compared = 0, calls = 0;
    voxels.light(
        {{b, 1, 1}}, std::vector<std::uint8_t>(cellCount(bricks), 1), kAllLight, *lit.p().layer().cache,
        [&](const BrickToLight& brick, int channel, const Chunk& chunk, int edge) {
            EXPECT_EQ(brick.brick, b);
            EXPECT_EQ(edge, 16);
            EXPECT_EQ(channel, static_cast<int>(calls++));
            const auto* const found = reinterpret_cast<const std::uint16_t*>(chunk.bytes.get());
            for (std::size_t n = 0; n < 4096; n += 7) {
                const glm::ivec3 in = gridPosition(n, glm::ivec3(16)), i = glm::ivec3(16, 0, 32) + in;
                if (!runs(1, i))
                    continue;
                float share = 1;
                for (std::size_t caster = 0; caster < 2; ++caster)
                    share *= lit.light->shadows()[caster].light(lit.placeOf(1, i), 1);
                ASSERT_NEAR(found[linearIndex(in, glm::ivec3(kChunkExtent))], 16384 * share, 1);
                ++compared;
            }
        });
    EXPECT_EQ(calls, 2u);
    EXPECT_GT(compared, 300u);
}

} // namespace
} // namespace tessera::test
