// tests/render/light/occlusion_test.cpp: local ambient occlusion of samples (render/light/occlusion.h)
// against course notes 6.1 written out once more, in double and without lanes.
#include "core/scene/preset.h"
#include "render/light/directions.h"
#include "render/light/occlusion.h"
#include "render/light/voxel_light.h"
#include "tests/support/native_fixture.h"
#include "tests/support/surface_fixture.h"

#include <cmath>
#include <gtest/gtest.h>
#include <memory>
#include <new>
#include <utility>

namespace tessera::test {
namespace {

TEST(SphereDirections, AreEvenlySpread) {
    for (const int count : {4, 8, 16, 20, 32, 64, 80, 128, 320, 512, 4096}) {
        ASSERT_TRUE(isDirectionCount(count));
        const std::vector<SphereDirection> all = sphereDirections(count);
        ASSERT_EQ(all.size(), static_cast<std::size_t>(count));
        glm::dvec3 sum(0), squares(0);
        double nearest = 4, whole = 0;
        for (std::size_t i = 0; i < all.size(); ++i) {
            const auto& [towards, part] = all[i];
            EXPECT_NEAR(glm::length(towards), 1, 1e-14);
            EXPECT_GT(part, 0.2 / count);
            EXPECT_LT(part, 3.5 / count);
            whole += part;
            sum += part * towards;
            squares += part * towards * towards;
            for (std::size_t j = i + 1; j < all.size() && count <= 512; ++j)
                nearest = std::min(nearest, glm::distance(towards, all[j].towards));
        }
        EXPECT_NEAR(whole, 1, 1e-12) << count;
        EXPECT_LT(glm::length(sum), 1e-12) << count;
        for (int axis = 0; axis < 3; ++axis)
            EXPECT_NEAR(squares[axis], 1.0 / 3, 1e-12) << count;
        // Caps of the sphere's area over the count, were they packed without gaps, are 4 / sqrt(count) apart.
        if (count <= 512) {
            EXPECT_GT(nearest, 1.2 / std::sqrt(count)) << count;
        }
    }
    for (const int count : {0, 1, 2, 3, 5, 12, 24, 33, 40, 100})
        EXPECT_FALSE(isDirectionCount(count)) << count;
}

// A direction stands for the area around it: means of even polynomials over the sphere are those of calculus.
// Directions of one weight would be off by some percent, because the solids' faces are not of one size.
TEST(SphereDirections, StandForTheirShareOfTheSphere) {
    for (const int count : {1024, 2048, 5120}) {
        double fourth = 0, mixed = 0, sixth = 0;
        for (const auto& [towards, part] : sphereDirections(count)) {
            fourth += part * std::pow(towards.z, 4);
            mixed += part * towards.x * towards.x * towards.y * towards.y;
            sixth += part * std::pow(towards.x, 6);
        }
        EXPECT_NEAR(fourth, 1.0 / 5, 4.0 / count) << count;
        EXPECT_NEAR(mixed, 1.0 / 15, 4.0 / count) << count;
        EXPECT_NEAR(sixth, 1.0 / 7, 8.0 / count) << count;
    }
}

// Weights of directions, in the mean over the sphere and of many directions: a quarter of the strength is
// theirs. A half space that hides all leaves (1/2 + s/4) / (1 + s/4) where they look away from it.
TEST(SphereDirections, WeighMoreOnOneSide) {
    const glm::dvec3 towards = glm::normalize(glm::dvec3(0.3, -0.5, 0.8));
    for (const double strength : {0.0, 1.0, 6.0}) {
        Occlusion occlusion{.rays = 5120};
        occlusion.weights = DirectionWeights{7.0 * towards, strength};
        double whole = 0, open = 0, along = 0;
        for (const auto& [direction, part] : occlusionDirections(occlusion)) {
            const double cosine = glm::dot(direction, towards);
            whole += part;
            open += cosine > 0 ? part : 0;
            along += part * cosine;
            EXPECT_NEAR(directionWeight(occlusion, direction),
                        (1 + strength * std::max(0.0, cosine)) / (1 + strength / 4), 1e-12);
        }
        EXPECT_NEAR(whole, 1, 1e-12);
        EXPECT_NEAR(open, (0.5 + strength / 4) / (1 + strength / 4), 1e-2 / std::sqrt(20)) << strength;
        EXPECT_NEAR(along, strength / 6 / (1 + strength / 4), 1e-3) << strength;
    }
    const std::vector<SphereDirection> even = sphereDirections(32), none = occlusionDirections({.rays = 32});
    for (std::size_t n = 0; n < even.size(); ++n) {
        EXPECT_EQ(none[n].part, even[n].part);
        EXPECT_EQ(none[n].towards, even[n].towards);
    }
    // The rays of a lattice carry them.
    Occlusion up{.rays = 32, .radiusMm = 4};
    up.weights = DirectionWeights{{0, 0, 1}, 3};
    VolumeInfo info;
    info.extentVoxels = glm::ivec3(40);
    info.patientFromVoxel = glm::dmat4(1);
    double whole = 0, above = 0;
    for (const OcclusionRay& ray : occlusionRays(up, info, 0).rays) {
        whole += ray.part;
        above += ray.direction.z > 0 ? ray.part : 0;
    }
    EXPECT_NEAR(whole, 1, 1e-12);
    EXPECT_GT(above, 0.68);
}

// What budgets are charged for a thread's work is what its samples take.
TEST(OcclusionRoom, BytesAreThoseOfItsSamples) {
    for (const glm::ivec3& reach : {glm::ivec3(0), glm::ivec3(3, 5, 4), glm::ivec3(31, 8, 17)})
        for (int kind = 0; kind < 8; ++kind) {
            const bool emits = (kind & 1) != 0, surfaces = (kind & 2) != 0, meshes = (kind & 4) != 0;
            const OcclusionRoom room(reach, emits, surfaces, meshes);
            std::size_t floats = room.extinction.size() + room.ofMeshes.size() + room.opacity.size() +
                                 room.low.size() + room.high.size() + room.light.size() + room.rest.size() +
                                 room.weights.size();
            for (const std::vector<float>& axis : room.normal)
                floats += axis.size();
            for (int c = 0; c < 3; ++c)
                floats += room.emission[static_cast<std::size_t>(c)].size() +
                          room.shine[static_cast<std::size_t>(c)].size();
            EXPECT_EQ(OcclusionRoom::bytes(reach, emits, surfaces, meshes), sizeof(float) * floats);
        }
}

/// Floats hold an opacity near 1 to 2^-24, and the transmittance of half a step to 2^-12. The mean over a ray
/// of one step has a quarter of that error, and as much again at the ray's end.
constexpr double kNear = 0x1p-12 / 2;

/// Equations 6.2 and 6.3 at a sample, straight from docs/sampling.md.
class Plainly {
  public:
    Plainly(Prepared& prepared, const Occlusion& occlusion, int level)
        : p_(prepared.p), occlusion_(occlusion), level_(level),
          samples_(*p_.layer().cache, p_.info(), level, nullptr) {}

    /// Light from all sides, and what tissue sends, red, green and blue.
    glm::dvec4 at(const glm::ivec3& sample) {
        const glm::dmat3 voxels = glm::inverse(glm::dmat3(p_.info().patientFromVoxel));
        glm::dvec4 sum(0);
        double weights = 0; // of all
        glm::dvec3 rise(0); // of extinction
        double beside = 0;
        for (int axis = 0; axis < 3; ++axis) {
            glm::ivec3 pitch(0);
            pitch[axis] = 1;
            const double before = extinction(sample - pitch), behind = extinction(sample + pitch);
            rise[axis] = 0.5 * (behind - before);
            beside += (before + behind) / 6;
        }
        const glm::dvec3 out = -(glm::transpose(voxels) * rise);
        const bool hemisphere =
            occlusion_.directions == OcclusionDirections::hemisphere && glm::length(out) > 0;
        const double edge = hemisphere ? std::min(1.0, glm::length(rise) / beside) : 0;
        const auto weightOf = [&](const glm::dvec3& direction) {
            const auto& more = occlusion_.weights;
            const double one =
                more ? 1 + more->strength * std::max(0.0, glm::dot(direction, glm::normalize(more->towards)))
                     : 1;
            return hemisphere
                       ? one * (1 - edge + 4 * edge * std::max(0.0, glm::dot(direction, glm::normalize(out))))
                       : one;
        };
        for (const auto& [direction, part] : sphereDirections(occlusion_.rays))
            weights += part * weightOf(direction);
        for (const auto& [direction, part] : sphereDirections(occlusion_.rays)) {
            const glm::dvec3 along = voxels * direction;
            const double steepest = std::max({std::abs(along.x), std::abs(along.y), std::abs(along.z)});
            const double stepMm = std::ldexp(1 / steepest, level_);
            const double steps = std::max(1.0, std::min(32.0, std::round(occlusion_.radiusMm / stepMm)));
            const double skipped = std::min(steps - 1, std::round(occlusion_.offsetMm / stepMm));
            const auto opacityAt = [&](double n) {
                return opacity(glm::dvec3(sample) + n * along / steepest, stepMm);
            };
            double through = 1, seen = 0;
            glm::dvec3 sent(0);
            for (double n = skipped; n <= steps; ++n) {
                const double here = opacityAt(n), part = n == skipped || n == steps ? 0.5 : 1;
                const bool falls =
                    n == skipped ? opacityAt(n + 1) + 0x1p-20 < here : here + 0x1p-20 < opacityAt(n - 1);
                const double taken = occlusion_.method == OcclusionMethod::rejecting && falls ? 0 : here;
                const double after = through * std::pow(1 - taken, part);
                seen += part * (through + after) / 2;
                sent += part * (through + after) / 2 * emissionAt(glm::dvec3(sample) + n * along / steepest);
                through = after;
            }
            const bool isLocal = occlusion_.method == OcclusionMethod::local;
            sum += part * weightOf(direction) / weights *
                   glm::dvec4(isLocal ? seen / (steps - skipped) : through,
                              occlusion_.emission * sent / (steps - skipped));
        }
        return sum;
    }
    bool showsNear(const glm::ivec3& sample) {
        const Optics& optics = p_.layer().optics;
        bool before = false, behind = false; // of the first surface
        for (int n = 0; n < 27; ++n) {
            const glm::ivec3 last = samples_.extent() - 1;
            const double value = samples_.at(
                glm::clamp(sample + glm::ivec3(n % 3, n / 3 % 3, n / 9) - 1, glm::ivec3(0), last));
            if (lookUp(optics, value).a > 0)
                return true;
            const bool isBehind =
                !optics.surfaces.empty() && value >= static_cast<double>(optics.surfaces.front().isovalue);
            (isBehind ? behind : before) = true;
        }
        return before && behind;
    }

  private:
    double extinction(const glm::ivec3& i) {
        if (glm::any(glm::lessThan(i, glm::ivec3(0))) ||
            glm::any(glm::greaterThanEqual(i, samples_.extent())))
            return 0;
        return occlusionExtinction(p_.layer().optics, samples_.at(i));
    }
    /// Between the samples around a place.
    template <typename T, typename At> static T between(const glm::dvec3& place, const At& at) {
        const glm::ivec3 low(glm::floor(place));
        T sum(0);
        for (int n = 0; n < 8; ++n) {
            const glm::ivec3 corner(n & 1, (n >> 1) & 1, n >> 2);
            const glm::dvec3 weights = 1.0 - glm::abs(place - glm::dvec3(low + corner));
            const double weight = weights.x * weights.y * weights.z;
            if (weight > 1e-12)
                sum += weight * at(low + corner);
        }
        return sum;
    }
    double opacity(const glm::dvec3& place, double stepMm) {
        return between<double>(place,
                               [&](const glm::ivec3& i) { return -std::expm1(-extinction(i) * stepMm); });
    }
    glm::dvec3 emissionAt(const glm::dvec3& place) {
        if (occlusion_.emission == 0)
            return glm::dvec3(0);
        return between<glm::dvec3>(place, [&](const glm::ivec3& i) {
            if (!(extinction(i) > 0))
                return glm::dvec3(0);
            const double value =
                p_.info().rescaleSlope * static_cast<double>(samples_.at(i)) + p_.info().rescaleIntercept;
            for (const Material& m : p_.layer().function.materials())
                if (m.from <= value && value < m.to)
                    return m.emission;
            return glm::dvec3(0);
        });
    }

    Planner& p_;
    Occlusion occlusion_;
    int level_;
    LatticeReader samples_;
};

struct Case {
    const char* store;
    const char* preset;
    Occlusion occlusion;
    std::vector<Isosurface> surfaces = {};
};

/// Samples of every chunk of every level, a few hundred a level, and every instruction set.
void expectAsPlainly(const Case& c, const glm::dmat4* place = nullptr) {
    Scene scene = sceneOn(infoOf(c.store), c.preset, 0, {16, 16});
    scene.surfaces = c.surfaces;
    if (c.occlusion.emission > 0) {
        TransferFunction function = presetFunction(c.preset, {-1000, 2000, true, 1, {}});
        function.setMaterials(
            {{60, 200, 0.2, 0.8, 0.2, 20, {1, 0.5, 0.25}}, {200, 900, 0.2, 0.8, 0.2, 20, {0, 0.5, 1}}});
        scene.volumes[0].transferFunction = function;
    }
    Prepared prepared(c.store, scene, true, 0, place);
    Planner& p = prepared.p;
    std::vector<std::vector<float>> first, firstShine;
    const native::PacketTargets targets = native::packetTargets();
    for (int t = 0; t < targets.count; ++t) {
        const native::PacketTarget* const target = targets.all[t];
        Occluder occluder(p.info(), p.layer().statistics, c.occlusion, target);
        occluder.setFunction(p.layer().table, p.layer().optics);
        OcclusionRoom room(occluder.mostReach(), occluder.gathersEmission(), occluder.seesSurfaces());
        std::size_t compared = 0, chunk = 0, doubtful = 0;
        double shade = 0, shine = 0;
        for (int level = occluder.finestLevel(); level < kLevelCount; ++level) {
            Plainly plainly(prepared, c.occlusion, level);
            const glm::ivec3 chunks = chunkGrid(p.info().extentVoxels, level);
            for (std::size_t n = 0; n < cellCount(chunks); ++n, ++chunk) {
                const glm::ivec3 at = gridPosition(n, chunks);
                const ChunkKey key{level, at.x, at.y, at.z};
                occluder.find(key, {}, true, *p.layer().cache, room);
                occluder.occlude(key, room);
                if (t > 0) {
                    EXPECT_EQ(room.light, first[chunk]) << target->name;
                    EXPECT_EQ(room.shine[1], firstShine[chunk]) << target->name;
                    continue;
                }
                first.push_back(room.light);
                firstShine.push_back(room.shine[1]);
                const glm::ivec3 extent = glm::min(
                    levelExtent(p.info().extentVoxels, level) - at * kChunkExtent, glm::ivec3(kChunkExtent));
                for (unsigned s = 0; s < cellCount(extent); s += level == 0 ? 97 : level == 1 ? 31 : 5) {
                    const glm::ivec3 sample = gridPosition(s, extent);
                    if (!plainly.showsNear(at * kChunkExtent + sample))
                        continue;
                    const glm::dvec4 light = plainly.at(at * kChunkExtent + sample);
                    const double expected = light.x;
                    const std::size_t here = linearIndex(sample, glm::ivec3(kChunkExtent));
                    const float found = room.light[here];
                    for (int n = 0; n < 3 && c.occlusion.emission > 0; ++n) {
                        ASSERT_NEAR(room.shine[static_cast<std::size_t>(n)][here], light[1 + n],
                                    kNear * c.occlusion.emission);
                        shine += light[1 + n];
                    }
                    if (c.occlusion.method == OcclusionMethod::rejecting &&
                        std::abs(static_cast<double>(found) - expected) > kNear)
                        ++doubtful; // opacities that differ by just what rejects
                    else
                        ASSERT_NEAR(found, expected, kNear) << c.store << " level " << level << " at "
                                                            << sample.x << "," << sample.y << "," << sample.z;
                    ++compared;
                    shade += 1 - expected;
                }
            }
        }
        if (t == 0) {
            EXPECT_GT(compared, 30u) << c.store;
            EXPECT_LE(doubtful, compared / 200) << c.store;
            EXPECT_GT(shade, 0.1 * static_cast<double>(compared)); // something is in the shade at all
            EXPECT_EQ(shine > 0.01 * static_cast<double>(compared), c.occlusion.emission > 0);
        }
    }
}

/// Of three chunks in a row the middle one alone shows something: the light of the first and of the middle
/// one reads no other.
TEST(Occluder, ReadsWhatShowsAlone) {
    const Stored stored([](const glm::dvec3& p) { return p.x > 33 && p.x < 60 ? 1 : 0; }, {96, 32, 32}, true);
    Scene scene = stored.scene({});
    scene.volumes[0].transferFunction = TransferFunction::fromExtinction({{0.5, 0}, {1, 1}}, {});
    const auto prepared = stored.prepare(scene);
    const Planner& p = prepared->p;
    Occluder occluder(p.info(), p.layer().statistics, Occlusion{.rays = 32, .radiusMm = 20});
    occluder.setFunction(p.layer().table, p.layer().optics);
    OcclusionRoom room(occluder.mostReach(), occluder.gathersEmission(), occluder.seesSurfaces());
    for (const int chunk : {0, 1}) {
        BrickCache cache(prepared->reader, prepared->budgets.ram, std::size_t{64} << 20, 1);
        occluder.find({0, chunk, 0, 0}, {}, true, cache, room);
        EXPECT_EQ(cache.counters().misses, 1u) << chunk;
    }
}

/// At the plane of a half space that hides all, nothing of the open side is hidden: 1 by the hemisphere, and
/// about half by the sphere. Where nothing is beside a place both are the same.
TEST(Occluder, LooksAwayFromAHalfSpace) {
    const Stored stored([](const glm::dvec3& p) { return p.x > 32 ? 1 : 0; }, {64, 64, 64}, true);
    Scene scene = stored.scene({});
    scene.volumes[0].transferFunction = TransferFunction::fromExtinction({{0.5, 0}, {1, 4}}, {});
    const auto prepared = stored.prepare(scene);
    const Planner& p = prepared->p;
    float seen[2][2]; // by directions: at the plane, and beside the volume's middle in the open
    for (const auto directions : {OcclusionDirections::sphere, OcclusionDirections::hemisphere}) {
        Occluder occluder(p.info(), p.layer().statistics,
                          Occlusion{.rays = 128, .radiusMm = 12, .directions = directions});
        occluder.setFunction(p.layer().table, p.layer().optics);
        OcclusionRoom room(occluder.mostReach(), false, occluder.seesSurfaces());
        EXPECT_EQ(occluder.seesSurfaces(), directions == OcclusionDirections::hemisphere);
        EXPECT_EQ(room.rest.empty(), directions == OcclusionDirections::sphere);
        const ChunkKey key{0, 0, 0, 0};
        occluder.find(key, {}, true, *p.layer().cache, room);
        occluder.occlude(key, room);
        const auto n = static_cast<std::size_t>(directions);
        seen[n][0] = room.light[linearIndex({31, 16, 16}, glm::ivec3(kChunkExtent))];
        seen[n][1] = room.light[linearIndex({30, 16, 16}, glm::ivec3(kChunkExtent))];
    }
    EXPECT_NEAR(seen[1][0], 1, 0.01);
    EXPECT_NEAR(seen[0][0], 0.5, 0.1) << "half a step of each ray is before the wall";
    EXPECT_NEAR(seen[1][1], seen[0][1], 1e-5) << "no surface is beside it";
}

/// Bricks drawn as one value have the light of the coarsest sample: dark deep in a medium, bright beside it.
TEST(VoxelLight, OfBricksOfOneValueFollowsWhatIsAround) {
    const Stored stored([](const glm::dvec3& p) { return p.x > 64 ? 1 : 0; }, {192, 160, 160}, true);
    Scene scene = stored.scene({});
    scene.volumes[0].transferFunction = TransferFunction::fromExtinction({{0.5, 0}, {1, 1}}, {});
    const auto prepared = stored.prepare(scene);
    const Planner& p = prepared->p;
    Lighting lighting;
    lighting.occlusion = Occlusion{.rays = 32, .radiusMm = 100, .bias = 0, .gamma = 1};
    VoxelLight light(p.info(), p.layer().statistics, lighting, 1);
    light.functionChanged(p.layer().table, p.layer().optics);
    BrickCache cache(prepared->reader, prepared->budgets.ram, std::size_t{64} << 20, 1);
    const auto share = [&](const glm::ivec3& brick) {
        return static_cast<double>(light.standing(linearIndex(brick, {6, 5, 5}), 0, 0, cache)) /
               static_cast<double>(lightTexel(1));
    };
    for (int turn = 0; turn < 2; ++turn) {
        EXPECT_LT(share({4, 2, 2}), 0.2);
        EXPECT_GT(share({0, 0, 0}), 0.5);
        EXPECT_GT(share({0, 2, 2}), share({1, 2, 2}));
    }
}

/// The chunks used last are made once; what is held stays, and what could not be made is made again.
TEST(ChunkExtinctions, AreThoseOfTheChunksUsedLast) {
    ChunkExtinctions kept;
    int made = 0;
    const auto get = [&](int chunk) {
        return kept.get({0, chunk, 0, 0}, [&, chunk](ChunkExtinctions::Samples& samples) {
            ++made;
            samples.extinction = std::make_unique<float[]>(1);
            samples.extinction[0] = static_cast<float>(chunk);
        });
    };
    constexpr int kMost = ChunkExtinctions::kMost;
    for (int turn = 0; turn < 2; ++turn)
        for (int chunk = 0; chunk < kMost; ++chunk)
            EXPECT_EQ(get(chunk)->extinction[0], static_cast<float>(chunk));
    EXPECT_EQ(made, kMost);
    const auto held = get(1);
    get(0);
    for (int chunk = kMost; chunk < 2 * kMost - 1; ++chunk)
        get(chunk);
    EXPECT_EQ(made, 2 * kMost - 1);
    get(0);
    EXPECT_EQ(made, 2 * kMost - 1) << "the last of the first ones is still there";
    get(1);
    EXPECT_EQ(made, 2 * kMost);
    EXPECT_EQ(held->extinction[0], 1) << "made room, but was held";
    kept.clear();
    EXPECT_EQ(get(0)->extinction[0], 0);
    EXPECT_EQ(made, 2 * kMost + 1);
    EXPECT_THROW(kept.get({1, 0, 0, 0}, [](ChunkExtinctions::Samples&) { throw std::bad_alloc(); }),
                 std::bad_alloc);
    EXPECT_NO_THROW(kept.get({1, 0, 0, 0}, [](ChunkExtinctions::Samples&) {}));
}

TEST(Occluder, IsWhatTheContractSays) {
    expectAsPlainly({"torso", "soft-tissue", {}});
    expectAsPlainly({"torso", "bone-1", {.rays = 80, .radiusMm = 9, .offsetMm = 2}});
    expectAsPlainly({"sphere", "bone-1", {.rays = 16, .radiusMm = 1000}});
    expectAsPlainly({"thin", "bone-1", {.rays = 8, .radiusMm = 0.01}});
    expectAsPlainly(
        {"torso", "soft-tissue", {.method = OcclusionMethod::positional, .rays = 20, .radiusMm = 8}});
    expectAsPlainly(
        {"torso", "soft-tissue", {.method = OcclusionMethod::rejecting, .rays = 16, .radiusMm = 8}});
    // Whole chunks lie behind the surface, and show nothing.
    expectAsPlainly({"torso", "bone-1", {.rays = 16, .radiusMm = 30}, {{-300, {1, 1, 1}, 0.02}}});
    expectAsPlainly({"torso", "soft-tissue", {.rays = 16, .radiusMm = 9, .emission = 7}});
    expectAsPlainly({"torso", "soft-tissue", {.rays = 20, .radiusMm = 9, .weights = {{{1, 2, -2}, 4}}}});
}

TEST(Occluder, HemispheresAreThoseOfThePlainSum) {
    constexpr auto kHemisphere = OcclusionDirections::hemisphere;
    expectAsPlainly({"torso", "soft-tissue", {.rays = 32, .radiusMm = 9, .directions = kHemisphere}});
    expectAsPlainly({"torso",
                     "bone-1",
                     {.method = OcclusionMethod::positional,
                      .rays = 20,
                      .radiusMm = 6,
                      .weights = {{{0, 1, 1}, 2}},
                      .directions = kHemisphere}});
    expectAsPlainly(
        {"torso",
         "soft-tissue",
         {.method = OcclusionMethod::rejecting, .rays = 16, .radiusMm = 24, .directions = kHemisphere}});
}

} // namespace
} // namespace tessera::test
