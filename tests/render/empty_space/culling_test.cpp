// Bricks that show nothing stand as one value: what is beside them must be drawn, and lit, as if they were
// there.
#include "tests/support/native_fixture.h"
#include "tests/support/scene_fixture.h"
#include "tests/support/surface_fixture.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace tessera::test;

struct Difference {
    std::size_t pixels = 0, shown = 0;
    float largest = 0;
};
Difference between(const Image& a, const Image& b) {
    Difference d;
    for (std::size_t i = 0; i < a.pixels.size(); ++i) {
        float worst = 0;
        for (int c = 0; c < 4; ++c)
            worst = std::max(worst, std::abs(a.pixels[i][c] - b.pixels[i][c]));
        d.pixels += worst > 0 ? 1 : 0;
        d.shown += b.pixels[i].a > 0.02f ? 1 : 0;
        d.largest = std::max(d.largest, worst);
    }
    return d;
}

/// The same scene with bricks culled and with none culled, at one level.
std::pair<Image, Image> withAndWithoutCulling(const std::string& store, const Scene& scene, int level) {
    std::vector<Image> pictures;
    for (const bool culling : {true, false}) {
        Prepared prepared(store, scene, culling);
        Selection s = prepared.p.layer().selection;
        s.counts = {};
        for (std::uint8_t& mine : s.levels) {
            if (mine != Selection::kEmpty)
                mine = static_cast<std::uint8_t>(level);
            ++s.counts[mine];
        }
        EXPECT_EQ(culling, s.counts[Selection::kEmpty] > 0) << "nothing to tell apart";
        prepared.p.setSelection(s);
        pictures.push_back(marchOn(prepared, marchFeatures(prepared.p, false)).image);
    }
    return {pictures[0], pictures[1]};
}

// At the finest level no bit differs, whatever the gradient. Two layers around a culled brick are invisible
// too, so that no gradient's stencil reaches from visible samples into it.
TEST(Culling, LitPicturesOfTheFinestLevelAreBitEqual) {
    const GlContext context({"software"});
    for (const char* store : {"torso", "abdomen", "head"}) {
        if (!std::filesystem::exists(storePath(store)))
            continue; // a scan that this machine lacks; the phantom is always there
        MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
        const VolumeInfo info = StoreReader(storePath(store), ram).info();
        for (const char* preset : {"bone-1", "skin-1"})
            for (const Gradient kind : {Gradient::central, Gradient::sobel, Gradient::centralHalf,
                                        Gradient::forward, Gradient::analytic, Gradient::cubic}) {
                if (kind != Gradient::central && store != std::string("torso"))
                    continue; // scans take long
                Scene scene = sceneOn(info, preset, 0, {96, 96});
                scene.shading.gradient = kind;
                scene.quality.stepVoxels = 1;
                const auto [culled, whole] = withAndWithoutCulling(store, scene, 0);
                const Difference d = between(culled, whole);
                EXPECT_EQ(d.pixels, 0u)
                    << store << ", " << preset << ", " << gradientNames()[static_cast<std::size_t>(kind)]
                    << ": of " << d.shown << " pixels, by up to " << d.largest;
            }
    }
}

// At coarser levels values beside a culled brick are blended with its mean, and so are gradients, a sample
// further in. This changes a small part of the level's own loss.
TEST(Culling, LitPicturesOfCoarserLevelsDifferByLessThanATwentiethOfTheLevelsOwnError) {
    const GlContext context({"software"});
    const auto rms = [](const Image& a, const Image& b) {
        double sum = 0;
        for (std::size_t i = 0; i < a.pixels.size(); ++i) {
            const glm::dvec4 d = glm::dvec4(a.pixels[i]) - glm::dvec4(b.pixels[i]);
            sum += glm::dot(d, d);
        }
        return std::sqrt(sum / static_cast<double>(a.pixels.size()));
    };
    for (const char* store : {"torso", "abdomen", "head"}) {
        if (!std::filesystem::exists(storePath(store)))
            continue;
        MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
        const VolumeInfo info = StoreReader(storePath(store), ram).info();
        for (const char* preset : {"bone-1", "skin-1"}) {
            Scene scene = sceneOn(info, preset, 0, {64, 64});
            scene.quality.stepVoxels = 1;
            const Image finest = withAndWithoutCulling(store, scene, 0).second;
            for (const int level : {1, 2, 3}) {
                const auto [culled, whole] = withAndWithoutCulling(store, scene, level);
                const double change = rms(culled, whole), own = rms(whole, finest);
                RecordProperty(std::string(store) + "-" + preset + "-" + std::to_string(level),
                               std::to_string(change / own));
                EXPECT_LE(change, own / 20) << store << ", " << preset << ", level " << level;
            }
        }
    }
}

// Smooth normals reach further: the cells around a culled brick are invisible too.
TEST(Culling, SmoothNormalsReadNoCulledBrick) {
    // A ball in noise, its skin half a voxel to seven voxels from the faces of bricks.
    for (const double radius : {12.5, 14.0, 15.5, 9.0}) {
        const Stored stored(
            [radius](const glm::dvec3& p) {
                return radius - glm::length(p - 80.0) + 0.3 * std::sin(40 * p.x + 9 * p.y * p.z);
            },
            glm::ivec3(160), true);
        for (const Gradient kind : {Gradient::sobel2, Gradient::sobel4}) {
            Scene scene = stored.scene({}, 0, 48);
            scene.volumes[0].transferFunction =
                TransferFunction::fromOpacity({{-1, 0}, {0, 0.5}, {3, 0.9}}, {}, 1);
            scene.shading.gradient = kind;
            const auto culled = stored.prepare(scene), all = stored.prepare(scene, false);
            EXPECT_GT(culled->p.layer().selection.counts[Selection::kEmpty], 20u);
            EXPECT_LT(culled->p.layer().selection.counts[Selection::kEmpty], 124u);
            EXPECT_EQ(differing(nativePicture(*culled).image, nativePicture(*all).image), 0u) << radius;
        }
    }
}

} // namespace
} // namespace tessera
