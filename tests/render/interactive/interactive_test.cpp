// Successive pictures converge to the still's picture, whatever moved before and in whatever order bricks
// arrived. Budgets hold after every step, no requested brick is evicted, and refinement always ends.
#include "core/base/program_folders.h"
#include "core/image/image_metrics.h"
#include "render/picture/render_scene.h"
#include "tests/support/interactive_fixture.h"

#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>
#include <thread>

namespace tessera {
namespace {

using namespace tessera::test;
using std::chrono::milliseconds;
using Clock = InteractiveRenderer::Clock;

Image still(const Scene& scene, std::size_t gpuBytes, Selection* levels = nullptr) {
    MemoryBudget ram("RAM", "--ram", kRam), gpu("GPU memory", "--gpu-memory", gpuBytes);
    const StoreReader reader(storePath("torso"), ram);
    RenderOptions options;
    options.device.text = "software";
    const RenderResult result = renderScene(scene, reader, ram, gpu, options);
    if (levels)
        levels->counts = result.bricksOfLevel;
    return result.image;
}

TEST(Interactive, ComesToTheStillsLevelsAndPicture) {
    const Scene scene = interactiveScene("bone-1", 0);
    // Ample memory: the finest that a pixel shows. It has one level here, which the still reads as such and a
    // renderer whose levels may change as mixed: pictures differ by rounding.
    Session ample(scene, std::size_t{1} << 30);
    ample.converge();
    Selection levels;
    const Image image = still(scene, std::size_t{1} << 30, &levels);
    EXPECT_EQ(ample.renderer.resident().counts, levels.counts);
    EXPECT_FALSE(isBlank(image));
    EXPECT_LE(compare(ample.renderer.picture(), image).luvMean, 1e-3);
    EXPECT_EQ(ample.renderer.repacks(), 0u);
}

// Isosurfaces alone and in a volume, also when another function comes: those of the still, which alone has a
// map of what is near surfaces.
TEST(Interactive, DrawsIsosurfacesAsTheStillDoes) {
    const std::size_t budget = std::size_t{1} << 30;
    Scene scene = interactiveScene("bone-1", 0, {32, 32});
    scene.surfaces = {{-300, {0.9, 0.6, 0.5}, 0.3}, {250, {0.95, 0.9, 0.8}, 1}};
    scene.volumes[0].transferFunction = TransferFunction::fromExtinction({}, {});
    ValueSummary values;
    values.isHu = true;
    const std::vector<TransferFunction> functions = {TransferFunction::fromExtinction({}, {}),
                                                     presetFunction("bone-1", values),
                                                     presetFunction("soft-tissue", values)};
    std::vector<Image> pictures;
    {
        Session session(scene, budget); // stills have contexts of their own, which must not come between
        for (const TransferFunction& function : functions) {
            session.renderer.setFunction(function);
            session.converge();
            pictures.push_back(session.renderer.picture());
        }
    }
    for (std::size_t i = 0; i < functions.size(); ++i) {
        SCOPED_TRACE(i);
        scene.volumes[0].transferFunction = functions[i];
        EXPECT_FALSE(isBlank(pictures[i]));
        EXPECT_LE(compare(pictures[i], still(scene, budget)).luvMean, 1e-3);
        if (i > 0) { // the volume is seen too
            EXPECT_GT(compare(pictures[0], pictures[i]).luvMean, 0.1);
        }
    }
}

// Any number of loaders, any deadline, any upload size: the levels and the picture that it comes to are the
// same.
class InteractiveEngines : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Engines, InteractiveEngines, testing::Bool(),
                         [](const auto& info) { return info.param ? "native" : "gpu"; });

TEST_P(InteractiveEngines, ArrivalOrderDoesNotMatter) {
    const Scene scene = interactiveScene("soft-tissue", 0);
    const std::size_t budget = gpuBytesFor(scene, 60, GetParam());
    Image first;
    for (const auto& [threads, each, upload] :
         {std::tuple(1, 3, std::size_t{1} << 16), std::tuple(4, 50, std::size_t{1} << 20),
          std::tuple(2, 1000, std::size_t{64} << 20)}) {
        InteractiveOptions options;
        options.threads = threads;
        options.uploadBytes = upload;
        options.dispatchMs = 5;
        Session session(scene, budget, options, storePath("torso"), GetParam());
        session.converge(milliseconds(each), 5000);
        ASSERT_TRUE(session.renderer.wanted());
        EXPECT_EQ(session.renderer.resident().levels, session.renderer.wanted()->levels);
        EXPECT_GT(session.renderer.predictedError().mean, 0) << "the budget must be short";
        if (first.pixels.empty())
            first = session.renderer.picture();
        EXPECT_TRUE(bitEqual(session.renderer.picture(), first));
    }
    EXPECT_FALSE(isBlank(first));
}

// With no page to spare, levels are those of the still, and the picture is too.
TEST(Interactive, WithTheSamePagesItIsTheStill) {
    const Scene scene = interactiveScene("soft-tissue", 0);
    InteractiveOptions options;
    options.spareShare = 0;
    Session session(scene, gpuBytesFor(scene, 40), options);
    session.converge();
    // A still of as many pages: its own fixed costs are less, so search the budget.
    Selection levels;
    for (std::size_t bytes = session.gpu.limitBytes(); bytes > 0; bytes -= std::size_t{1} << 16) {
        MemoryBudget ram("RAM", "--ram", kRam), gpu("GPU memory", "--gpu-memory", bytes);
        const StoreReader reader(storePath("torso"), ram);
        const Planner p = planScene(scene, reader, session.engine->limits(), {ram, gpu, 2});
        if (p.chosen.atlasPages > session.renderer.atlasPages())
            continue;
        ASSERT_EQ(p.chosen.atlasPages, session.renderer.atlasPages());
        const Image image = still(scene, bytes, &levels);
        EXPECT_EQ(session.renderer.resident().counts, levels.counts);
        EXPECT_TRUE(bitEqual(session.renderer.picture(), image));
        return;
    }
    FAIL() << "no budget gives as many pages";
}

TEST(Interactive, FirstPictureIsWholeAndPicturesGetBetter) {
    const Scene scene = interactiveScene("bone-1", 0, {96, 96});
    InteractiveOptions options;
    options.uploadBytes = std::size_t{1} << 18;
    options.firstPatience = std::chrono::hours(1); // whatever else this machine does
    Session session(scene, std::size_t{1} << 30, options);
    std::vector<Image> pictures;
    for (int n = 0; n < 1000; ++n) {
        const auto progress = session.renderer.advance(Clock::now() + milliseconds(100));
        if (progress.newPicture)
            pictures.push_back(session.renderer.picture());
        if (progress.converged)
            break;
    }
    ASSERT_GE(pictures.size(), 2u);
    EXPECT_FALSE(isBlank(pictures.front()));
    EXPECT_GT(compare(pictures.front(), pictures.back()).luvMean, 0);
}

// Random cameras, functions, paths, deadlines and cancels on a budget of few pages. After every step the
// budgets hold, and the resident bricks fit and match the table that rays read. It converges to the requested
// levels.
TEST_P(InteractiveEngines, AnyStepsKeepTheBudgetAndComeToAnEnd) {
    const Scene scene = interactiveScene("soft-tissue", 0, {32, 32});
    for (const std::size_t pages : {3u, 12u, 40u}) {
        SCOPED_TRACE(pages);
        Session session(scene, gpuBytesFor(scene, pages, GetParam()), {}, storePath("torso"), GetParam());
        std::mt19937 random(static_cast<unsigned>(pages));
        const VolumeInfo info = session.reader.info();
        const ValueSummary values = [] {
            ValueSummary v;
            v.isHu = true;
            return v;
        }();
        for (int step = 0; step < 120; ++step) {
            switch (random() % 8) {
            case 0:
                session.renderer.setCamera(cameraNumber(static_cast<int>(random() % 3), info, {32, 32}));
                break;
            case 1:
                session.renderer.setFunction(presetFunction(random() % 2 ? "bone-1" : "soft-tissue", values));
                break;
            case 2:
                session.renderer.cancel();
                break;
            case 3:
                session.renderer.setPath({cameraNumber(static_cast<int>(random() % 3), info, {32, 32})});
                break;
            default:
                break;
            }
            session.renderer.advance(Clock::now() + milliseconds(random() % 20));
            session.checkStep();
            if (HasFailure())
                return;
        }
        session.converge();
        EXPECT_EQ(session.renderer.resident().levels, session.renderer.wanted()->levels);
        EXPECT_EQ(session.renderer.picture().size, glm::ivec2(32, 32));
    }
}

// The bricks of the path's next views are in RAM in advance, and the pictures are the same.
TEST(Interactive, ThePathsNextBricksAreLoadedAhead) {
    const Scene scene = interactiveScene("soft-tissue", 2);
    const std::size_t budget = gpuBytesFor(scene, 60);
    std::uint64_t misses[2];
    Image pictures[2];
    for (const bool ahead : {false, true}) { // one after the other: a context each
        Session session(scene, budget);
        const Camera next = cameraNumber(1, session.reader.info(), {64, 64});
        if (ahead)
            session.renderer.setPath({next});
        session.converge();
        // Loaders go on by themselves; until nothing more comes.
        auto before = session.renderer.cacheCounters().misses;
        for (int still = 0; still < 30; ++still) {
            std::this_thread::sleep_for(milliseconds(10));
            if (const auto now = session.renderer.cacheCounters().misses; now != before)
                before = now, still = 0;
        }
        session.renderer.setCamera(next);
        session.converge();
        misses[ahead] = session.renderer.cacheCounters().misses - before;
        pictures[ahead] = session.renderer.picture();
    }
    EXPECT_GT(misses[false], 4u);
    // Not all: the second choice, by what is seen there, is not known before.
    EXPECT_LE(3 * misses[true], 2 * misses[false]);
    EXPECT_TRUE(bitEqual(pictures[false], pictures[true]));
}

// A chunk that cannot be read is told of once, by file; all else goes on and comes to its end.
TEST(Interactive, ADamagedChunkIsToldOfOnce) {
    const ScratchFolder scratch;
    std::filesystem::copy(storePath("torso"), scratch / "torso.zarr",
                          std::filesystem::copy_options::recursive);
    const std::filesystem::path shard = scratch / "torso.zarr/0/c/0/0/0";
    ASSERT_TRUE(std::filesystem::exists(shard));
    {
        std::fstream file(shard, std::ios::in | std::ios::out | std::ios::binary);
        const auto middle = static_cast<std::streamoff>(std::filesystem::file_size(shard) / 2);
        file.seekg(middle);
        const int byte = file.get();
        file.seekp(middle);
        file.put(static_cast<char>(byte ^ 0x20));
    }
    const Scene scene = interactiveScene("soft-tissue", 0);
    Session session(scene, std::size_t{1} << 30, {}, scratch / "torso.zarr");
    int told = 0;
    bool converged = false;
    for (int n = 0; n < 500 && !converged; ++n)
        try {
            converged = session.renderer.advance(Clock::now() + milliseconds(200)).converged;
        } catch (const std::exception& e) {
            ++told;
            EXPECT_THAT(e.what(), testing::HasSubstr("torso.zarr/0/c/0/0/0"));
        }
    EXPECT_TRUE(converged);
    EXPECT_EQ(told, 1);
    EXPECT_FALSE(isBlank(session.renderer.picture()));
    session.checkStep();
}

TEST_P(InteractiveEngines, DeadlinesAreKeptAndWorkGoesOn) {
    const Scene scene = interactiveScene("soft-tissue", 0, {160, 160});
    InteractiveOptions options;
    options.dispatchMs = 2;
    Session session(scene, std::size_t{1} << 30, options, storePath("torso"), GetParam());
    session.converge();
    session.renderer.setCamera(cameraNumber(1, session.reader.info(), {160, 160}));
    // A deadline that has passed leaves the picture in the works; it comes to its end in as many calls as it
    // takes, and not in one.
    int calls = 0;
    while (!session.renderer.advance(Clock::now() + std::chrono::microseconds(1)).newPicture &&
           calls < 100000)
        ++calls;
    EXPECT_GT(calls, 3);
    EXPECT_LT(calls, 100000);
    const Image whole = session.renderer.picture();
    session.renderer.cancel();
    session.converge();
    EXPECT_EQ(session.renderer.picture().size, whole.size);
}

} // namespace
} // namespace tessera
