// tests/render/plan/budget_test.cpp: budgets are guarantees. Every accepted scene is drawn inside its budget,
// a smaller budget never gives a finer level, and a refusal names a minimum that is then accepted.
#include "core/base/budget_error.h"
#include "render/picture/render_scene.h"
#include "tests/support/scene_fixture.h"

#include "bricking/import/importer.h"
#include "core/base/program_folders.h"
#include "datasets/phantom.h"

#include <gmock/gmock.h>
#include <optional>
#include <set>
#include <vector>

namespace tessera::test {
namespace {

using ::testing::HasSubstr;
constexpr std::size_t kRoomy = std::size_t{1} << 30;
constexpr glm::ivec2 kPicture{24, 20};

/// The message of the OverBudget that action throws; "" where it throws nothing.
template <typename Action> std::string refusal(const Action& action) {
    try {
        action();
    } catch (const OverBudget& error) {
        return error.what();
    }
    return "";
}

/// The floor as a reader of the message would type it.
std::size_t statedFloor(const std::string& message) {
    const std::string before = "needs at least ";
    const std::size_t start = message.find(before) + before.size();
    EXPECT_GE(start, before.size()) << message;
    const std::size_t end = message.find_first_of(" ,", message.find(' ', start) + 1);
    return parseBytes(message.substr(start, end - start), "floor");
}

/// From roomy down to below the floor, in even steps of the logarithm; the floor itself and its neighbours
/// too.
std::vector<std::size_t> budgetsDown(std::size_t floor, std::size_t roomy, int steps) {
    std::vector<std::size_t> budgets = {floor + 1, floor};
    for (int i = 0; i < steps; ++i)
        budgets.push_back(static_cast<std::size_t>(
            static_cast<double>(roomy) *
            std::pow(0.6 * static_cast<double>(floor) / static_cast<double>(roomy), i / (steps - 1.0))));
    std::sort(budgets.rbegin(), budgets.rend());
    return budgets;
}

TEST(RenderBudget, GpuMemoryIsKeptAndLevelsCoarsenMonotonically) {
    const GlContext context({"software"});
    const TextureLimits limits{context.max3dTextureSize(), context.maxTextureBytes()};
    int accepted = 0, refused = 0;
    std::set<int> levels;
    for (const char* name : {"torso", "marschner-lobb", "checkerboard"}) {
        SCOPED_TRACE(name);
        Budgets budgets;
        const StoreReader reader(storePath(name), budgets.ram);
        Scene scene = sceneOn(reader.info(), name == std::string("torso") ? "bone-1" : "auto", 0, kPicture);
        scene.quality.fetch = Fetch::hardware;
        const auto prepare = [&](MemoryBudget& gpu) {
            return planScene(scene, reader, limits, {budgets.ram, gpu, 2}, LevelChoice::oneForAll);
        };
        MemoryBudget none("GPU memory", "--gpu-memory", 1);
        const std::string message = refusal([&] { prepare(none); });
        EXPECT_THAT(message, HasSubstr("--gpu-memory"));
        const std::size_t floor = statedFloor(message);
        int coarsest = 0;
        for (const std::size_t bytes : budgetsDown(floor, 24 << 20, 16)) {
            SCOPED_TRACE(bytes);
            MemoryBudget gpu("GPU memory", "--gpu-memory", bytes);
            // Messages round up, so a budget a little below the stated floor may still do.
            if (bytes < floor) {
                const std::string why = refusal([&] { prepare(gpu); });
                if (!why.empty()) {
                    EXPECT_EQ(statedFloor(why), floor) << why;
                    ++refused;
                    continue;
                }
                EXPECT_GT(static_cast<double>(bytes), 0.99 * static_cast<double>(floor));
            }
            // Accepted: then no allocation of the GPU ray caster may fail.
            Planner p = prepare(gpu);
            const std::uint32_t features =
                kFeatureSkipping | kFeatureHardware |
                (texelFormat(p.info().type).normalised ? std::uint32_t{kFeatureNormalised} : 0u);
            Work work;
            const March march(features, p.view.frame, p.info(), p.strides(), p.layer().optics,
                              &p.layer().occupancy, gpu);
            Atlas atlas(p.info(), p.layer().selection, pagesFor(p.layer().selection.counts), limits, gpu,
                        budgets.ram);
            atlas.bricks.load(*p.layer().cache, work);
            EXPECT_LE(gpu.peakBytes(), bytes);
            EXPECT_GE(p.layer().selection.finest(), coarsest) << "finer than with a larger budget";
            coarsest = std::max(coarsest, p.layer().selection.finest());
            levels.insert(p.layer().selection.finest());
            ++accepted;
        }
        // No byte is wasted where a finer level would have fitted: the finest needs the most.
        MemoryBudget roomy("GPU memory", "--gpu-memory", kRoomy);
        EXPECT_EQ(prepare(roomy).layer().selection.finest(), 0);
    }
    EXPECT_GE(accepted, 30);
    EXPECT_GE(refused, 3);
    EXPECT_GE(levels.size(), 3u) << "the budgets must force several levels";
}

/// Samples of all bricks that a picture was drawn from, bytes. Those of level 5 stand in the index.
std::size_t sampleBytes(const RenderResult& result) {
    std::size_t samples = 0;
    for (int level = 0; level + 1 < kLevelCount; ++level) {
        const auto edge = static_cast<std::size_t>(kBrickExtent >> level);
        samples += result.bricksOfLevel[static_cast<std::size_t>(level)] * edge * edge * edge;
    }
    return 2 * samples;
}

// The native engine has no memory but RAM: what its planes take counts as the GPU's, all of it.
TEST(RenderBudget, NativePlanesCountAndTheBudgetIsKept) {
    MemoryBudget trial("RAM", "--ram", kRoomy), none("GPU memory", "--gpu-memory", 1);
    const StoreReader first(storePath("torso"), trial);
    Scene scene = sceneOn(first.info(), "bone-1", 0, kPicture);
    scene.surfaces = {{250, {0.95, 0.9, 0.8}, 0.5}};
    RenderOptions options;
    options.engine = EngineKind::native;
    options.threads = 2;
    const std::size_t floor = statedFloor(refusal([&] { renderScene(scene, first, trial, none, options); }));
    int accepted = 0, refused = 0;
    std::set<std::size_t> taken;
    for (const std::size_t bytes : budgetsDown(floor, 24 << 20, 12)) {
        SCOPED_TRACE(bytes);
        MemoryBudget ram("RAM", "--ram", kRoomy), gpu("GPU memory", "--gpu-memory", bytes);
        const StoreReader reader(storePath("torso"), ram);
        std::optional<RenderResult> result;
        const std::string why = refusal([&] { result = renderScene(scene, reader, ram, gpu, options); });
        if (!result) {
            EXPECT_LT(bytes, floor);
            EXPECT_EQ(statedFloor(why), floor) << why;
            ++refused;
            continue;
        }
        EXPECT_FALSE(isBlank(result->image));
        EXPECT_LE(gpu.peakBytes(), bytes);
        const std::size_t samples = sampleBytes(*result);
        EXPECT_GE(gpu.peakBytes(), samples + rayStateBytes(kPicture)) << "planes are not charged";
        taken.insert(samples);
        ++accepted;
    }
    EXPECT_GE(accepted, 8);
    EXPECT_GE(refused, 1);
    EXPECT_GE(taken.size(), 3u) << "the budgets must force other levels";
}

TEST(RenderBudget, RamIsKeptAndNeverChangesThePicture) {
    int accepted = 0, refused = 0;
    for (const char* name : {"torso", "marschner-lobb"})
        for (const EngineKind engine : {EngineKind::mirror, EngineKind::reference}) {
            SCOPED_TRACE(std::string(name) + " " + tessera::name(engine));
            // RAM may not hold what choosing a level per brick needs; then all have one level, and the
            // picture is that of every budget that is as small.
            std::array<std::optional<Image>, 2> expected;
            std::size_t floor = 0;
            bool perBrick = false;
            const auto render = [&](std::size_t bytes, std::size_t& peak) {
                MemoryBudget ram("RAM", "--ram", bytes), gpu("GPU memory", "--gpu-memory", kRoomy);
                const StoreReader reader(storePath(name), ram);
                floor = renderFloorBytes(reader.info(), kPicture, pictureBytesPerPixel(engine), 2);
                Scene scene =
                    sceneOn(reader.info(), name == std::string("torso") ? "bone-1" : "auto", 0, kPicture);
                RenderOptions options;
                options.engine = engine;
                options.threads = 2;
                const RenderResult result = renderScene(scene, reader, ram, gpu, options);
                peak = ram.peakBytes();
                perBrick = result.predictedError.has_value();
                return result.image;
            };
            std::size_t peak = 0;
            expected[1] = render(kRoomy, peak);
            EXPECT_TRUE(perBrick);
            EXPECT_FALSE(isBlank(*expected[1]));
            const std::size_t exact = floor;
            const int steps = engine == EngineKind::mirror ? 16 : 2; // the reference takes its time
            for (const std::size_t bytes : budgetsDown(exact, 64 << 20, steps)) {
                SCOPED_TRACE(bytes);
                if (bytes < exact) {
                    const std::string why = refusal([&] { render(bytes, peak); });
                    EXPECT_THAT(why, HasSubstr("--ram"));
                    EXPECT_EQ(why.find(formatBytes(exact)) != std::string::npos, true) << why;
                    ++refused;
                    continue;
                }
                const Image image = render(bytes, peak);
                std::optional<Image>& same = expected[perBrick ? 1 : 0];
                if (!same)
                    same = image;
                EXPECT_TRUE(bitEqual(image, *same));
                EXPECT_LE(peak, bytes);
                ++accepted;
            }
        }
    EXPECT_GE(accepted, 30);
    EXPECT_GE(refused, 4);
}

TEST(RenderBudget, TheFloorsOfBothTogetherSuffice) {
    MemoryBudget trial("RAM", "--ram", kRoomy), noGpu("GPU memory", "--gpu-memory", 1);
    const StoreReader first(storePath("torso"), trial);
    const Scene scene = sceneOn(first.info(), "bone-1", 0, kPicture);
    const std::size_t ramBytes =
        renderFloorBytes(first.info(), kPicture, pictureBytesPerPixel(EngineKind::gpu), 0);
    const std::size_t gpuBytes = statedFloor(refusal([&] {
        planScene(scene, first, TextureLimits{}, {trial, noGpu, 0}, LevelChoice::oneForAll);
    }));
    MemoryBudget ram("RAM", "--ram", ramBytes), gpu("GPU memory", "--gpu-memory", gpuBytes);
    const StoreReader reader(storePath("torso"), ram);
    RenderOptions options;
    options.device.text = "software";
    const RenderResult result = renderScene(scene, reader, ram, gpu, options);
    EXPECT_FALSE(isBlank(result.image));
    EXPECT_LE(ram.peakBytes(), ramBytes);
    EXPECT_LE(gpu.peakBytes(), gpuBytes);
    EXPECT_GT(result.level, 0); // a page holds many bricks of a coarse level, so not always the coarsest
}

TEST(ImportBudget, IsKeptFromTheFloorUp) {
    const ScratchFolder folder;
    const auto import = [&](std::size_t bytes) {
        const auto source = makePhantom("sphere", {70, 90, 67}, 2);
        MemoryBudget ram("RAM", "--ram", bytes);
        ImportOptions options;
        options.force = true;
        options.threads = 2;
        options.durable = false;
        importToStore(*source, folder / "a.zarr", ram, options);
        EXPECT_LE(ram.peakBytes(), bytes);
        const StoreReader reader(folder / "a.zarr", ram);
        return reader.contentHash();
    };
    const std::size_t floor = [] {
        const auto source = makePhantom("sphere", {70, 90, 67}, 2);
        return importFloorBytes(*source, source->info(), 2);
    }();
    const std::string expected = import(kRoomy);
    int accepted = 0;
    for (const std::size_t bytes : budgetsDown(floor, 64 << 20, 12)) {
        SCOPED_TRACE(bytes);
        if (bytes < floor) {
            EXPECT_THAT(refusal([&] { import(bytes); }), HasSubstr(formatBytes(floor)));
            continue;
        }
        EXPECT_EQ(import(bytes), expected) << "the budget must not change the store";
        ++accepted;
    }
    EXPECT_GE(accepted, 10);
}

} // namespace
} // namespace tessera::test
