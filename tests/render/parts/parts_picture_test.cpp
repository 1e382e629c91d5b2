// tests/render/parts/parts_picture_test.cpp: pictures that several share, each with a part of the volume,
// equal those of one: samples are the same, sums differ by rounding. Memory is that of each; levels are those
// for all.
#include "core/base/error.h"
#include "render/picture/render_scene.h"
#include "tests/support/scene_fixture.h"
#include "tests/support/thread_group.h"

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <mutex>
#include <string_view>
#include <vector>

namespace tessera::test {
namespace {

using ::testing::HasSubstr;

constexpr glm::ivec2 kShared(61, 47);
constexpr double kSame = 1e-5; // linear light

struct SharedScene {
    const char* name;
    int camera;
    void (*change)(Scene&);
};

RenderResult drawBy(ProcessGroup* group, const Scene& scene, std::size_t gpuBytes = std::size_t{256} << 20,
                    PartReport* report = nullptr) {
    MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20), gpu("GPU memory", "--gpu-memory", gpuBytes);
    const StoreReader store(storePath("torso"), ram);
    RenderOptions options;
    options.engine = EngineKind::native;
    options.threads = 1;
    options.searching = true;
    options.group = group;
    RenderResult result = renderScene(scene, store, ram, gpu, options);
    EXPECT_LE(gpu.peakBytes(), gpu.limitBytes());
    if (report)
        *report = {result.part, result.work.bytesUploaded, ram.peakBytes(), gpu.peakBytes()};
    return result;
}

/// Each member's picture, and what it held.
struct ByMember {
    std::vector<RenderResult> results;
    std::vector<PartReport> reports;
};
ByMember drawByAll(int count, const Scene& scene, std::size_t gpuBytes = std::size_t{256} << 20) {
    ByMember all{std::vector<RenderResult>(static_cast<std::size_t>(count)),
                 std::vector<PartReport>(static_cast<std::size_t>(count))};
    ThreadGroup::meet(count, [&](ProcessGroup& group) {
        const auto rank = static_cast<std::size_t>(group.rank());
        all.results[rank] = drawBy(&group, scene, gpuBytes, &all.reports[rank]);
    });
    return all;
}

double largestDifference(const Image& a, const Image& b) {
    EXPECT_EQ(a.size, b.size);
    double largest = 0;
    for (std::size_t i = 0; i < std::min(a.pixels.size(), b.pixels.size()); ++i)
        for (int c = 0; c < 4; ++c) {
            const double difference = std::abs(static_cast<double>(a.pixels[i][c]) - b.pixels[i][c]);
            largest = difference <= largest ? largest : difference; // NaN too
        }
    return largest;
}

Scene sceneFor(const SharedScene& row) {
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    const StoreReader store(storePath("torso"), ram);
    Scene scene = sceneOn(store.info(), "soft-tissue", row.camera, kShared);
    scene.quality.stepVoxels = 0.7;
    scene.quality.pixels.samples = 1;
    row.change(scene);
    return scene;
}

class PartsOf : public ::testing::TestWithParam<SharedScene> {};

TEST_P(PartsOf, ComeToThePictureOfOne) {
    const Scene scene = sceneFor(GetParam());
    const RenderResult whole = drawBy(nullptr, scene);
    ASSERT_FALSE(isBlank(whole.image));
    if (std::string_view(GetParam().name) == "mixed") {
        EXPECT_LT(whole.bricksOfLevel[0], whole.residentBricks);
    }
    for (const int count : {1, 2, 5}) {
        const ByMember all = drawByAll(count, scene);
        std::uint64_t most = 0;
        for (const PartReport& report : all.reports)
            most = std::max(most, report.bytesOfBricks);
        if (count == 5) {
            EXPECT_LT(static_cast<double>(most), 0.75 * static_cast<double>(whole.work.bytesUploaded));
        }
        for (const RenderResult& result : all.results) {
            EXPECT_LE(largestDifference(result.image, whole.image), kSame) << count << " parts";
            EXPECT_TRUE(bitEqual(result.image, all.results.front().image));
            EXPECT_EQ(result.bricksOfLevel, whole.bricksOfLevel);
            EXPECT_EQ(result.stepVoxels, whole.stepVoxels);
        }
    }
}

void asItIs(Scene&) {}
void mixLevels(Scene& scene) {
    scene.imageSize = {19, 15}; // coarse levels are enough far away
    scene.quality.sampling = Sampling::limited;
}
void unlit(Scene& scene) {
    scene.shading.on = false;
    scene.quality.integrator = Integrator::preintegrated;
}
void choose(Scene& scene) {
    scene.quality.automaticStep = true;
    scene.quality.pixels.samples = PixelSampling::kAutomatic;
}
void occlude(Scene& scene) {
    scene.lighting.occlusion.emplace();
    scene.quality.integrator = Integrator::linear;
}
void crop(Scene& scene) {
    CropBox box;
    box.space = CropBox::Space::voxels;
    box.low = {17, 20, 31};
    box.high = {120, 97, 139};
    scene.cuts.boxes = {box};
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, PartsOf,
    ::testing::Values(SharedScene{"oblique", 0, asItIs}, SharedScene{"parallel", 1, asItIs},
                      SharedScene{"inside", 2, asItIs}, SharedScene{"mixed", 0, mixLevels},
                      SharedScene{"mixedInside", 2, mixLevels}, SharedScene{"unlit", 0, unlit},
                      SharedScene{"chosen", 0, choose}, SharedScene{"occluded", 2, occlude},
                      SharedScene{"cropped", 1, crop}),
    [](const auto& row) { return row.param.name; });

TEST(Parts, LoseAtMostWhatRaysThatEndLeaveOut) {
    Scene scene = sceneFor({"", 0, asItIs});
    scene.quality.terminationTransmittance = 1.0 / 64;
    const double lost =
        largestDifference(drawByAll(4, scene).results.front().image, drawBy(nullptr, scene).image);
    EXPECT_GT(lost, kSame);
    EXPECT_LE(lost, 1.2 * scene.quality.terminationTransmittance); // times the brightest colour, lit
}

TEST(Parts, TakeFinerLevelsIntoTheMemoryOfAll) {
    const Scene scene = sceneFor({"", 0, asItIs});
    constexpr std::size_t kShort = std::size_t{3} << 20;
    const RenderResult one = drawBy(nullptr, scene, kShort);
    const ByMember all = drawByAll(4, scene, kShort);
    EXPECT_GT(all.results.front().bricksOfLevel[0], 3 * one.bricksOfLevel[0] / 2);
    for (const PartReport& report : all.reports)
        EXPECT_LE(report.gpuPeak, kShort);
}

TEST(Parts, ThatPlanDifferentlyAreRefused) {
    const Scene scene = sceneFor({"", 0, asItIs});
    std::mutex mutex;
    std::vector<std::string> refusals;
    ThreadGroup::meet(3, [&](ProcessGroup& group) {
        Scene mine = scene;
        mine.quality.stepVoxels = group.rank() == 1 ? 0.7 : 0.71;
        try {
            drawBy(&group, mine);
        } catch (const InputError& e) {
            const std::lock_guard lock(mutex);
            refusals.push_back(e.what());
        }
    });
    EXPECT_THAT(refusals,
                ::testing::AllOf(::testing::SizeIs(3), ::testing::Each(HasSubstr("different plans"))));
}

TEST(Parts, AreRefusedOfWhatCrossesThem) {
    const std::vector<std::pair<void (*)(Scene&), std::string>> scenes = {
        {[](Scene& s) { s.mode = Mode::maximum; }, "mode composite"},
        {[](Scene& s) { s.surfaces.emplace_back(); }, "isosurfaces"},
        {[](Scene& s) { s.lighting.transport.emplace(); }, "paths of light"},
        {[](Scene& s) { s.lighting.lights.push_back({}), s.lighting.lights.back().shadow = true; },
         "shadows"},
        {[](Scene& s) { s.quality.maxError = 1; }, "no error bound"},
        {[](Scene& s) { crop(s), s.cuts.boxes.front().keep = Keep::outside; }, "inside"}};
    for (const auto& [change, words] : scenes) {
        const Scene scene = sceneFor({"", 0, change});
        ThreadGroup::meet(1, [&](ProcessGroup& group) {
            try {
                drawBy(&group, scene);
                ADD_FAILURE() << words;
            } catch (const InputError& e) {
                EXPECT_THAT(e.what(), HasSubstr("--ranks: expected"));
                EXPECT_THAT(e.what(), HasSubstr(words));
            }
        });
    }
}

} // namespace
} // namespace tessera::test
