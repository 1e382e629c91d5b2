// The content of the picture: all that is shown, nothing of it cut off, and nothing else.
#include "bricking/import/importer.h"
#include "core/base/program_folders.h"
#include "render/picture/render_scene.h"
#include "render/plan/framing.h"
#include "tests/bench/lod/framing.h"
#include "tests/support/formula_source.h"
#include "tests/support/scene_fixture.h"

#include <gtest/gtest.h>
#include <mutex>
#include <set>

namespace tessera {
namespace {

using namespace tessera::test;
using bench::Framing;
using bench::framingOf;

Scene fittedScene(const std::string& preset, const FittedView& view, const glm::ivec2& size) {
    Scene scene;
    SceneVolume volume;
    volume.transferFunction = preset;
    scene.volumes = {volume};
    scene.imageSize = size;
    scene.camera = view;
    return scene;
}

/// The region that a picture of the scene shows, by the GPU ray caster.
Framing drawn(const Scene& scene, const StoreReader& store, Camera* camera = nullptr) {
    MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20),
        gpu("GPU memory", "--gpu-memory", std::size_t{512} << 20);
    RenderOptions options;
    options.device.text = "software";
    const RenderResult result = renderScene(scene, store, ram, gpu, options);
    if (camera)
        *camera = result.camera;
    return framingOf(result.image);
}

/// A ball of value 1000 in air, and what else is asked for.
std::unique_ptr<StoreReader> ballStore(const ScratchFolder& folder, const Formula& also, MemoryBudget& ram) {
    VolumeInfo info;
    info.extentVoxels = glm::ivec3(160);
    info.type = ValueType::f32;
    FormulaSource source(info, [also](const glm::dvec3& p) {
        const double ball = 1000 * std::clamp(20 - glm::length(p - glm::dvec3(60, 70, 90)), 0.0, 1.0);
        return std::max(ball, also ? also(p) : 0.0);
    });
    ImportOptions options;
    options.durable = false;
    importToStore(source, folder / "v.zarr", ram, options);
    return std::make_unique<StoreReader>(folder / "v.zarr", ram);
}

TEST(Framing, FillsThePictureAndCutsNothingOff) {
    for (const char* name : {"torso", "sphere", "checkerboard", "abdomen", "head"}) {
        if (!std::filesystem::exists(storePath(name)))
            continue; // a scan that this machine lacks; phantoms are always there
        MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20);
        const StoreReader store(storePath(name), ram);
        const bool hu = store.info().unit == "HU";
        for (const char* preset : {"auto", "bone-1", "skin-1", "lung-1"})
            for (const View view : {View::anterior, View::left, View::inferior}) {
                if (preset != std::string("auto") && !hu)
                    continue;
                for (const Projection projection : {Projection::perspective, Projection::parallel}) {
                    if (projection == Projection::parallel && view != View::anterior)
                        continue;
                    const Scene scene = fittedScene(preset, {view, projection}, {96, 72});
                    const Framing framing = drawn(scene, store);
                    const std::string what = std::string(name) + ", " + preset + ", " +
                                             viewNames()[static_cast<std::size_t>(view)];
                    EXPECT_GE(framing.span, 0.85) << what;
                    EXPECT_EQ(framing.cutOff, 0) << what;
                }
            }
    }
}

TEST(Framing, OfTheVolumesBoxIsAsItWas) {
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    const StoreReader store(storePath("torso"), ram);
    Camera camera;
    drawn(fittedScene("bone-1", {View::left, Projection::parallel, Fit::volume}, {40, 40}), store, &camera);
    const Camera expected = fitCamera(store.info(), View::left, Projection::parallel, {40, 40});
    EXPECT_EQ(camera.position, expected.position);
    EXPECT_EQ(camera.focalPoint, expected.focalPoint);
    EXPECT_EQ(camera.parallelScale, expected.parallelScale);
}

/// Notes which chunks are told before they are read.
class ToldSource final : public ChunkSource {
  public:
    explicit ToldSource(const ChunkSource& source) : source_(source) {}
    const VolumeInfo& info() const override { return source_.info(); }
    void readChunk(const ChunkKey& key, std::span<std::byte> out) const override {
        source_.readChunk(key, out);
        const std::lock_guard lock(mutex_);
        reads += 1, readAsTold += told_.contains(key);
    }
    void willRead(std::span<const ChunkKey> keys) const override {
        const std::lock_guard lock(mutex_);
        told_.insert(keys.begin(), keys.end());
    }
    std::size_t told() const { return told_.size(); }
    mutable int reads = 0, readAsTold = 0;

  private:
    const ChunkSource& source_;
    mutable std::mutex mutex_;
    mutable std::set<ChunkKey> told_;
};

// A server far away is asked for bricks together, not for one after another.
TEST(Framing, TellsWhatItWillRead) {
    MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20);
    const StoreReader store(storePath("torso"), ram);
    const Statistics statistics = loadStatistics(store, ram, 0);
    for (const char* preset : {"bone-1", "skin-1"}) {
        const TransferTable table = makeTable(presetFunction(preset, summarise(statistics, store.info())));
        const ToldSource source(store);
        fittedCamera({}, source, statistics, table, {}, {512, 512}, ram, 2);
        EXPECT_GT(source.reads, 4);
        EXPECT_GE(source.readAsTold, source.reads * 4 / 5);
        EXPECT_LE(source.told(), static_cast<std::size_t>(source.reads) * 4);
    }
}

// Neither the threads, nor the engine, nor a budget of RAM that just suffices, nor the size of the picture.
TEST(Framing, DependsOnTheSceneAlone) {
    MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20);
    const StoreReader store(storePath("torso"), ram);
    const Statistics statistics = loadStatistics(store, ram, 0);
    const TransferTable table = makeTable(presetFunction("vessels-1", summarise(statistics, store.info())));
    const auto fitted = [&](int threads, std::size_t bytes, const glm::ivec2& size) {
        MemoryBudget own("RAM", "--ram", bytes);
        const Camera camera = fittedCamera({}, store, statistics, table, {}, size, own, threads);
        EXPECT_EQ(own.usedBytes(), 0u);
        return camera.position;
    };
    const glm::dvec3 expected = fitted(1, std::size_t{256} << 20, {512, 512});
    EXPECT_EQ(fitted(3, std::size_t{256} << 20, {512, 512}), expected);
    EXPECT_EQ(fitted(2, framingBytes(store.info(), 2), {512, 512}), expected);
    EXPECT_EQ(fitted(2, std::size_t{256} << 20, {64, 64}), expected);
    EXPECT_THROW(fitted(2, framingBytes(store.info(), 2) / 2, {512, 512}), InputError);
}

// A ball in a large empty volume fills the picture, wherever it is. An outlying voxel and an invisible haze
// do not move the camera. A small visible object does, and is inside.
TEST(Framing, IsMovedByWhatIsSeenOnly) {
    using Points = std::vector<OpacityPoint>;
    const Points soft = {{0, 0}, {100, 0.00003}, {300, 0.01}, {1000, 1}}, steep = {{300, 0}, {301, 1}};
    const auto show = [](const Formula& also, const Points& opacity) {
        const ScratchFolder folder;
        MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20);
        const auto store = ballStore(folder, also, ram);
        Scene scene = fittedScene("auto", {}, {128, 128});
        scene.volumes.front().transferFunction = TransferFunction::fromOpacity(opacity, {}, 1);
        Camera camera;
        const Framing framing = drawn(scene, *store, &camera);
        EXPECT_GE(framing.span, 0.85);
        EXPECT_EQ(framing.cutOff, 0);
        return camera.position;
    };
    const glm::dvec3 alone = show({}, soft);
    const auto voxelAt = [](const glm::dvec3& p, int x, int y, int z) {
        return glm::ivec3(glm::floor(p)) == glm::ivec3(x, y, z);
    };
    EXPECT_EQ(show([](const glm::dvec3& p) { return p.x > 128 ? 60.0 : 0.0; }, soft), alone);
    // Opaque, but as wide as a thirtieth of a voxel, less than a pixel.
    EXPECT_EQ(show([&](const glm::dvec3& p) { return voxelAt(p, 150, 20, 20) ? 301.5 : 0.0; }, steep),
              show({}, steep));
    const glm::dvec3 wider = show(
        [](const glm::dvec3& p) { return glm::length(p - glm::dvec3(150, 70, 20)) < 3 ? 900.0 : 0.0; }, soft);
    EXPECT_GT(glm::length(wider - alone), 20);
}

// Surfaces are shown as the volume is, alone too; where nothing is shown the volume's box is.
TEST(Framing, TakesInIsosurfacesAndFallsBackToTheBox) {
    const ScratchFolder folder;
    MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20);
    const auto store = ballStore(folder, {}, ram);
    Scene scene = fittedScene("auto", {}, {96, 96});
    scene.volumes.front().transferFunction = TransferFunction::fromOpacity({}, {}, 1);
    Camera camera;
    EXPECT_EQ(drawn(scene, *store, &camera).share, 0);
    EXPECT_EQ(camera.position,
              fitCamera(store->info(), View::anterior, Projection::perspective, {96, 96}).position);
    scene.surfaces = {{500, glm::dvec3(1), 0.3}};
    const Framing framing = drawn(scene, *store);
    EXPECT_GE(framing.span, 0.9);
    EXPECT_EQ(framing.cutOff, 0);
}

// A camera for what cuts keep: the ball fills the picture, whatever else the volume shows beside it.
TEST(Framing, KeptIsWhatCutsLeave) {
    const ScratchFolder folder;
    MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20);
    const auto store = ballStore(
        folder, [](const glm::dvec3& p) { return p.y > 120 ? 1000. : 0.; }, ram);
    for (const Projection projection : {Projection::perspective, Projection::parallel}) {
        Scene scene = fittedScene("auto", {View::left, projection, Fit::kept}, {96, 96});
        EXPECT_NEAR(drawn(scene, *store).span, 0.969, 0.03) << "without cuts as what is shown";
        scene.cuts.boxes = {{{30, 40, 60}, {90, 100, 120}, CropBox::Space::voxels, Keep::inside}};
        Camera kept, shown;
        const Framing framing = drawn(scene, *store, &kept);
        EXPECT_GE(framing.span, 0.93);
        EXPECT_EQ(framing.cutOff, 0);
        std::get<FittedView>(scene.camera).fit = Fit::shown;
        EXPECT_LT(drawn(scene, *store, &shown).span, 0.5) << "cameras are fitted to the uncut volume";
        EXPECT_NE(kept, shown);
    }
}

} // namespace
} // namespace tessera
