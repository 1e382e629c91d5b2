// Errors of pictures for which finest bricks must be read: measured from a quarter of the picture's bytes, or
// not.
#include "bricking/import/importer.h"
#include "core/base/program_folders.h"
#include "core/image/image_metrics.h"
#include "render/picture/render_scene.h"
#include "tests/support/formula_source.h"
#include "tests/support/scene_fixture.h"

#include <array>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace tessera::test;

constexpr glm::ivec2 kSize(768, 768);

/// A slab of many bricks, seen face on: waves that the level of two voxels loses, in front of longer ones.
class Slab : public testing::Test {
  protected:
    Slab() {
        info_.type = ValueType::i16;
        info_.extentVoxels = {1024, 1024, 32};
        MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20);
        std::array<double, 1024> fine, wide;
        for (std::size_t i = 0; i < fine.size(); ++i) {
            const auto at = static_cast<double>(i);
            fine[i] = std::sin(1.0 * at), wide[i] = std::sin(0.011 * at);
        }
        FormulaSource source(info_, [&](const glm::dvec3& p) {
            const auto x = static_cast<std::size_t>(p.x), y = static_cast<std::size_t>(p.y);
            return 500 + 200 * wide[x] * wide[y] + 250 * (1 + wide[x]) * fine[x] * fine[y];
        });
        importToStore(source, folder_ / "v.zarr", ram, {});
    }
    Scene scene() const {
        Scene scene = sceneOn(info_, "bone-1", 1, kSize);
        SceneVolume& volume = scene.volumes[0];
        volume.path = folder_ / "v.zarr";
        volume.transferFunction = TransferFunction::fromOpacity(
            {{300, 0}, {1100, 0.2}}, {{300, {1, 0.3, 0.2}}, {1000, {1, 1, 0.9}}}, 1);
        scene.camera = fitCamera(info_, View::superior, Projection::parallel, kSize);
        scene.shading.on = false;
        scene.quality.stepVoxels = 1;
        scene.quality.pixels.samples = 4;
        return scene;
    }
    static RenderResult drawn(const Scene& scene, Verify verify, std::size_t gpuBytes) {
        MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20), gpu("GPU memory", "--gpu-memory", gpuBytes);
        const StoreReader reader(scene.volumes[0].path, ram);
        RenderOptions options;
        options.engine = EngineKind::native;
        options.threads = 2;
        options.verify = verify;
        const RenderResult result = renderScene(scene, reader, ram, gpu, options);
        EXPECT_LE(ram.peakBytes(), ram.limitBytes());
        EXPECT_LE(gpu.peakBytes(), gpu.limitBytes());
        return result;
    }

    const ScratchFolder folder_;
    VolumeInfo info_;
};

void expectHolds(const std::optional<Estimate>& e, double is) {
    ASSERT_TRUE(e);
    EXPECT_GE(is, 0.95 * e->low); // the truth has noise of its own
    EXPECT_LE(is, 1.05 * e->high);
    EXPECT_LE(e->high, 2 * e->low) << "it tells something";
}

TEST_F(Slab, ErrorsOfCoarseLevelsAreMeasuredFromClusters) {
    Scene fine = scene();
    fine.quality.stepVoxels = 0.25;
    fine.quality.pixels.samples = 8;
    fine.quality.pixels.seed = 77;
    fine.quality.maxError = 0;
    const Image truth = drawn(fine, Verify::none, std::size_t{400} << 20).image;
    for (const std::size_t mib : {54, 17}) {
        SCOPED_TRACE(mib);
        const RenderResult r = drawn(scene(), Verify::quick, mib << 20);
        EXPECT_GT(r.bricksOfLevel[1] + r.bricksOfLevel[2] + r.bricksOfLevel[3], r.residentBricks / 4)
            << "coarse levels";
        ASSERT_TRUE(r.measured);
        const PictureMeasurement& m = *r.measured;
        EXPECT_LE(4 * m.bytesRead, r.work.bytesUploaded);
        const ImageDifference is = compare(r.image, truth);
        if (mib < 20) {
            EXPECT_NE(m.whyNot.find("more than a quarter of the picture's bytes"), std::string::npos)
                << m.whyNot;
            EXPECT_FALSE(m.all.rms || m.all.luvMean || m.all.luvP99 || m.all.luvP99Bound);
            continue;
        }
        ASSERT_EQ(m.whyNot, "");
        EXPECT_GT(m.bytesRead, 0u);
        EXPECT_FALSE(m.all.luvP99 || m.all.luvP99Bound) << "clusters are too few";
        EXPECT_LT(4 * m.all.clusters, m.all.shown);
        expectHolds(m.all.rms, is.rms);
        expectHolds(m.all.luvMean, is.luvMean);
    }
}

} // namespace
} // namespace tessera
