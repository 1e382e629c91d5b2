// tests/render/occlusion_test.cpp: local ambient occlusion of samples (render/light/occlusion.h) against
// course notes 6.1 written out once more, in double and without lanes.
#include "render/light/directions.h"
#include "render/light/occlusion.h"
#include "tests/support/native_fixture.h"

#include <cmath>
#include <gtest/gtest.h>
#include <utility>

namespace tessera::test {
namespace {

TEST(SphereDirections, AreEvenlySpread) {
    for (const int count : {4, 8, 16, 20, 32, 64, 80, 128, 320, 512, 4096}) {
        ASSERT_TRUE(isDirectionCount(count));
        const std::vector<glm::dvec3> all = sphereDirections(count);
        ASSERT_EQ(all.size(), static_cast<std::size_t>(count));
        glm::dvec3 sum(0), squares(0);
        double nearest = 4;
        for (std::size_t i = 0; i < all.size(); ++i) {
            EXPECT_NEAR(glm::length(all[i]), 1, 1e-14);
            sum += all[i];
            squares += all[i] * all[i];
            for (std::size_t j = i + 1; j < all.size() && count <= 512; ++j)
                nearest = std::min(nearest, glm::distance(all[i], all[j]));
        }
        EXPECT_LT(glm::length(sum), 1e-9 * count) << count;
        for (int axis = 0; axis < 3; ++axis)
            EXPECT_NEAR(squares[axis], count / 3.0, 1e-9 * count) << count;
        // Caps of the sphere's area over the count, were they packed without gaps, are 4 / sqrt(count) apart.
        if (count <= 512) {
            EXPECT_GT(nearest, 1.2 / std::sqrt(count)) << count;
        }
    }
    for (const int count : {0, 1, 2, 3, 5, 12, 24, 33, 40, 100})
        EXPECT_FALSE(isDirectionCount(count)) << count;
}

/// Equations 6.2 and 6.3 at a sample, straight from docs/sampling.md.
class Plainly {
  public:
    Plainly(Prepared& prepared, const Occlusion& occlusion, int level)
        : p_(prepared.p), occlusion_(occlusion), level_(level),
          samples_(*p_.volume.cache, p_.info(), level, nullptr) {}

    double at(const glm::ivec3& sample) {
        const glm::dmat3 voxels = glm::inverse(glm::dmat3(p_.info().patientFromVoxel));
        const std::vector<glm::dvec3> directions = sphereDirections(occlusion_.rays);
        double sum = 0;
        for (const glm::dvec3& direction : directions) {
            const glm::dvec3 along = voxels * direction;
            const double steepest = std::max({std::abs(along.x), std::abs(along.y), std::abs(along.z)});
            const double stepMm = std::ldexp(1 / steepest, level_);
            const double steps = std::max(1.0, std::min(32.0, std::round(occlusion_.radiusMm / stepMm)));
            const double skipped = std::min(steps - 1, std::round(occlusion_.offsetMm / stepMm));
            double through = 1, seen = 0, last = opacity(glm::dvec3(sample), stepMm);
            for (double n = skipped + 1; n <= steps; ++n) {
                const glm::dvec3 place = glm::dvec3(sample) + n * along / steepest;
                double taken = opacity(place, stepMm);
                if (occlusion_.method == OcclusionMethod::rejecting &&
                    taken + 0x1p-20 < std::exchange(last, taken))
                    taken = 0;
                const double after = through * (1 - taken);
                seen += (through + after) / 2;
                through = after;
            }
            sum += occlusion_.method == OcclusionMethod::local ? seen / (steps - skipped) : through;
        }
        return sum / static_cast<double>(directions.size());
    }
    bool showsNear(const glm::ivec3& sample) {
        for (int n = 0; n < 27; ++n)
            if (extinction(sample + glm::ivec3(n % 3, n / 3 % 3, n / 9) - 1) > 0)
                return true;
        return false;
    }

  private:
    double extinction(const glm::ivec3& i) {
        if (glm::any(glm::lessThan(i, glm::ivec3(0))) ||
            glm::any(glm::greaterThanEqual(i, samples_.extent())))
            return 0;
        return lookUp(p_.volume.optics, samples_.at(i)).a;
    }
    double opacity(const glm::dvec3& place, double stepMm) {
        const glm::ivec3 low(glm::floor(place));
        double sum = 0;
        for (int n = 0; n < 8; ++n) {
            const glm::ivec3 corner(n & 1, (n >> 1) & 1, n >> 2);
            const glm::dvec3 weights = 1.0 - glm::abs(place - glm::dvec3(low + corner));
            const double weight = weights.x * weights.y * weights.z;
            if (weight > 1e-12)
                sum += weight * -std::expm1(-extinction(low + corner) * stepMm);
        }
        return sum;
    }

    ScenePlan& p_;
    Occlusion occlusion_;
    int level_;
    LatticeReader samples_;
};

struct Case {
    const char* store;
    const char* preset;
    Occlusion occlusion;
};

/// Samples of every chunk of every level, a few hundred a level, and every set of instructions.
void expectAsPlainly(const Case& c, const glm::dmat4* place = nullptr) {
    Prepared prepared(c.store, sceneOn(infoOf(c.store), c.preset, 0, {16, 16}), true, 0, place);
    ScenePlan& p = prepared.p;
    std::vector<std::vector<float>> first;
    const native::PacketTargets targets = native::packetTargets();
    for (int t = 0; t < targets.count; ++t) {
        const native::PacketTarget* const target = targets.all[t];
        Occluder occluder(p.info(), p.volume.statistics, c.occlusion, target);
        occluder.setFunction(p.volume.table, p.volume.optics);
        OcclusionRoom room(occluder.mostReach());
        std::size_t compared = 0, chunk = 0, doubtful = 0;
        double shade = 0;
        for (int level = occluder.finestLevel(); level < kLevelCount; ++level) {
            Plainly plainly(prepared, c.occlusion, level);
            const glm::ivec3 chunks = chunkGrid(p.info().extentVoxels, level);
            for (std::size_t n = 0; n < cellCount(chunks); ++n, ++chunk) {
                const glm::ivec3 at = gridPosition(n, chunks);
                const ChunkKey key{level, at.x, at.y, at.z};
                occluder.find(key, {}, *p.volume.cache, room);
                occluder.occlude(key, room);
                if (t > 0) {
                    EXPECT_EQ(room.light, first[chunk]) << target->name;
                    continue;
                }
                first.push_back(room.light);
                const glm::ivec3 extent = glm::min(
                    levelExtent(p.info().extentVoxels, level) - at * kChunkExtent, glm::ivec3(kChunkExtent));
                for (unsigned s = 0; s < cellCount(extent); s += level == 0 ? 97 : level == 1 ? 31 : 5) {
                    const glm::ivec3 sample = gridPosition(s, extent);
                    if (!plainly.showsNear(at * kChunkExtent + sample))
                        continue;
                    const double expected = plainly.at(at * kChunkExtent + sample);
                    const float found = room.light[linearIndex(sample, glm::ivec3(kChunkExtent))];
                    if (c.occlusion.method == OcclusionMethod::rejecting &&
                        std::abs(static_cast<double>(found) - expected) > 5e-5)
                        ++doubtful; // opacities that differ by just what rejects
                    else
                        ASSERT_NEAR(found, expected, 5e-5) << c.store << " level " << level << " at "
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
        }
    }
}

TEST(Occluder, IsWhatTheContractSays) {
    expectAsPlainly({"torso", "soft-tissue", {}});
    expectAsPlainly({"torso", "bone", {.rays = 80, .radiusMm = 9, .offsetMm = 2}});
    expectAsPlainly({"sphere", "bone", {.rays = 16, .radiusMm = 1000}});
    expectAsPlainly({"thin", "bone", {.rays = 8, .radiusMm = 0.01}});
    expectAsPlainly(
        {"torso", "soft-tissue", {.method = OcclusionMethod::positional, .rays = 20, .radiusMm = 8}});
    expectAsPlainly(
        {"torso", "soft-tissue", {.method = OcclusionMethod::rejecting, .rays = 16, .radiusMm = 8}});
}

} // namespace
} // namespace tessera::test
