// tests/render/backends/engine_test.cpp: the addition of an engine and a plane (docs/design.md, "How to
// add"): a minimal one of each, which rendering uses unchanged. The work of existing engines can be cut
// anywhere.
#include "render/backends/mirror/mirror_engine.h"
#include "render/backends/native/native_engine.h"
#include "render/backends/reference/reference_engine.h"
#include "tests/support/scene_fixture.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <mutex>
#include <vector>

namespace tessera {
namespace {

using namespace tessera::test;

/// A plane in host memory: the sum of a brick's stored values at its place.
class SumPlane : public Plane {
  public:
    explicit SumPlane(ValueType type) : type_(type) {}
    void put(const AtlasSlot& slot, const BrickSamples& samples, Work&) override {
        double sum = 0;
        for (int z = 0; z < samples.edge; ++z)
            for (int y = 0; y < samples.edge; ++y)
                for (int x = 0; x < samples.edge; ++x) {
                    const std::size_t at =
                        linearIndex(samples.first + glm::ivec3(x, y, z), glm::ivec3(kChunkExtent));
                    sum += storedValue(type_, samples.chunk.bytes.get() + at * bytesPerValue(type_));
                }
        sums.push_back({slot, sum});
    }
    void finish() override { ++finished; }
    void publish(std::span<const BrickEntry> entries) override { published = entries.size(); }

    std::vector<std::pair<AtlasSlot, double>> sums;
    std::size_t published = 0;
    int finished = 0;

  private:
    ValueType type_;
};

TEST(Planes, EveryPlaneGetsEveryBrickAtItsPlace) {
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    const VolumeInfo info = StoreReader(storePath("torso"), ram).info();
    Prepared prepared("torso", sceneOn(info, "bone-1", 0, {8, 8}));
    Planner& p = prepared.p;
    SumPlane first(info.type), second(info.type);
    BrickResidency bricks(info, p.layer().selection, pagesFor(p.layer().selection.counts), TextureLimits{},
                          {&first, &second}, prepared.budgets.ram);
    Work work;
    bricks.load(*p.layer().cache, work);
    ASSERT_EQ(first.sums.size(), p.layer().selection.shownBricks());
    EXPECT_EQ(first.sums.size(), second.sums.size());
    EXPECT_EQ(work.bricksUploaded, first.sums.size());
    EXPECT_EQ(first.published, p.layer().selection.levels.size());
    EXPECT_GE(second.finished, 1);
    LatticeReader samples(*p.layer().cache, info, p.layer().selection.finest(), nullptr);
    std::size_t found = 0;
    for (std::size_t b = 0; b < p.layer().selection.levels.size(); ++b) {
        const auto slot = bricks.slotOf(b);
        if (!slot)
            continue;
        const auto at = std::find_if(first.sums.begin(), first.sums.end(), [&](const auto& s) {
            return s.first.originTexels() == slot->originTexels();
        });
        ASSERT_NE(at, first.sums.end()) << b;
        const int edge = kBrickExtent >> slot->level;
        const glm::ivec3 origin = gridPosition(b, p.layer().selection.bricks) * edge;
        const glm::ivec3 end = glm::min(origin + edge, samples.extent());
        if (end != origin + edge)
            continue; // beyond the volume's edge values are the fill's
        double sum = 0;
        for (int z = origin.z; z < end.z; ++z)
            for (int y = origin.y; y < end.y; ++y)
                for (int x = origin.x; x < end.x; ++x)
                    sum += samples.at({x, y, z});
        EXPECT_EQ(at->second, sum) << b;
        ++found;
    }
    EXPECT_GT(found, 5u);
}

/// The least of an engine: a ray is as bright as its share of the longest one is.
class LengthEngine : public Engine {
  public:
    class Caster : public RayCaster {
      public:
        void begin(const Rays& rays) override {
            frame_ = rays.frame;
            picture_ = Image(glm::ivec2(frame_.imageSize));
            row_ = 0;
        }
        bool draw(const Slicing&, Clock::time_point deadline, Work& work) override {
            do
                drawRow(work);
            while (++row_ < picture_.size.y && Clock::now() < deadline);
            return row_ == picture_.size.y;
        }
        Image image() const override { return picture_; }

      private:
        void drawRow(Work& work) {
            for (int x = 0; x < picture_.size.x; ++x) {
                const auto ray = segmentedRay(
                    cast<float>(frame_), {static_cast<float>(x) + 0.5f, static_cast<float>(row_) + 0.5f});
                const float bright = static_cast<float>(ray.count) * 1e-3f;
                picture_.pixels[static_cast<std::size_t>(row_ * picture_.size.x + x)] = glm::vec4(bright);
                work.segments += static_cast<std::uint64_t>(ray.count);
            }
        }

        RayFrame<double> frame_;
        Image picture_;
        int row_ = 0;
    };
    About about() const override {
        About about;
        about.device = "none";
        return about;
    }
    void open(const FramePlan&, std::size_t) override { ++opened; }
    std::unique_ptr<RayCaster> caster(const CasterOptions&, MemoryBudget&) override {
        return std::make_unique<Caster>();
    }
    std::unique_ptr<VisibilityCounter> counter(MemoryBudget&) override { return nullptr; }
    std::size_t opened = 0;
};

TEST(Engines, TheLeastEngineDraws) {
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    const VolumeInfo info = StoreReader(storePath("torso"), ram).info();
    Prepared prepared("torso", sceneOn(info, "bone-1", 0, {12, 9}));
    LengthEngine engine;
    Work work;
    EXPECT_FALSE(loadBricks(engine, prepared.p, prepared.budgets.gpu, work));
    EXPECT_EQ(engine.opened, 1u);
    const auto caster = engine.caster({}, prepared.budgets.gpu);
    caster->begin(raysOf(prepared.p));
    EXPECT_EQ(drawToTheEnd(*caster, engine, prepared.p, Slicing{}, work), 1);
    const Image image = caster->image();
    EXPECT_GT(image.pixels[4 * 12 + 6].r, image.pixels[0].r);
    EXPECT_GT(work.segments, 0u);
}

// A deadline that has passed cuts an engine's work into the least pieces; the picture is the same, and what
// rays hit too.
TEST(Engines, ADeadlineChangesNoPicture) {
    const GlContext context({"software"});
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    const VolumeInfo info = StoreReader(storePath("torso"), ram).info();
    Scene scene = sceneOn(info, "bone-1", 0, {70, 61});
    scene.surfaces = {{250, glm::dvec3(1), 0.5}};
    Prepared prepared("torso", scene);
    GpuEngine gpu(context, prepared.budgets.gpu, prepared.budgets.ram);
    MirrorEngine mirror(2);
    for (Engine* engine : {static_cast<Engine*>(&gpu), static_cast<Engine*>(&mirror)}) {
        Work work;
        loadBricks(*engine, prepared.p, prepared.budgets.gpu, work);
        const auto caster = engine->caster({false, true, false}, prepared.budgets.gpu);
        caster->begin(raysOf(prepared.p));
        EXPECT_TRUE(caster->draw({}, RayCaster::Clock::time_point::max(), work));
        const Image whole = caster->image();
        const auto hits = caster->hits();
        EXPECT_EQ(hits.size(), whole.pixels.size());
        caster->begin(raysOf(prepared.p));
        Slicing slicing;
        slicing.fixedTile = 32;
        int pieces = 1;
        while (!caster->draw(slicing, RayCaster::Clock::time_point::min(), work))
            ++pieces;
        EXPECT_GT(pieces, 1);
        EXPECT_TRUE(bitEqual(caster->image(), whole));
        EXPECT_EQ(caster->hits(), hits);
        engine->close();
    }
}

// Exact fetches for a while leave the device's filter as it was.
TEST(Engines, FiltersAreWhatTheyWereAfterExactFetches) {
    const GlContext context({"software"});
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    Scene scene = sceneOn(StoreReader(storePath("torso"), ram).info(), "bone-1", 0, {24, 24});
    scene.quality.fetch = Fetch::hardware;
    Prepared prepared("torso", scene);
    GpuEngine gpu(context, prepared.budgets.gpu, prepared.budgets.ram);
    Work work;
    loadBricks(gpu, prepared.p, prepared.budgets.gpu, work);
    GpuCaster caster(prepared.p, gpu, CasterOptions{}, prepared.budgets.gpu);
    const auto picture = [&] {
        caster.begin(raysOf(prepared.p));
        drawToTheEnd(caster, gpu, prepared.p, {}, work);
        return caster.image();
    };
    const std::uint32_t asked = caster.features();
    ASSERT_TRUE(asked & kFeatureHardware);
    const Image filtered = picture();
    prepared.p.setFetch(Fetch::exact);
    const Image exact = picture();
    EXPECT_FALSE(caster.features() & kFeatureHardware);
    EXPECT_FALSE(bitEqual(exact, filtered));
    prepared.p.setFetch(Fetch::hardware);
    EXPECT_TRUE(bitEqual(picture(), filtered));
    EXPECT_EQ(caster.features(), asked);
}

TEST(Engines, TheReferenceIsCutLikewise) {
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    const VolumeInfo info = StoreReader(storePath("torso"), ram).info();
    const Scene scene = sceneOn(info, "bone-1", 0, {30, 21});
    Prepared prepared("torso", scene);
    ReferenceEngine engine(2);
    Work work;
    loadBricks(engine, prepared.p, prepared.budgets.gpu, work);
    const auto caster = engine.caster({}, prepared.budgets.gpu);
    caster->begin(raysOf(prepared.p));
    EXPECT_TRUE(caster->draw({}, RayCaster::Clock::time_point::max(), work));
    const Image whole = caster->image();
    caster->begin(raysOf(prepared.p));
    EXPECT_FALSE(caster->draw({}, RayCaster::Clock::time_point::min(), work));
    while (!caster->draw({}, RayCaster::Clock::time_point::min(), work)) {
    }
    EXPECT_TRUE(bitEqual(caster->image(), whole));
}

// Shares of a picture's rays: those of the GPU never fall and meet the area after every tile; all end at 1.
TEST(Engines, TellTheShareOfTheirRays) {
    const GlContext context({"software"});
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    Prepared prepared("torso", sceneOn(StoreReader(storePath("torso"), ram).info(), "bone-1", 0, {40, 37}));
    GpuEngine gpu(context, prepared.budgets.gpu, prepared.budgets.ram);
    NativeEngine native(2, prepared.budgets.gpu, prepared.budgets.ram);
    MirrorEngine mirror(2);
    ReferenceEngine reference(2);
    for (Engine* engine : {static_cast<Engine*>(&gpu), static_cast<Engine*>(&native),
                           static_cast<Engine*>(&mirror), static_cast<Engine*>(&reference)}) {
        Work work;
        loadBricks(*engine, prepared.p, prepared.budgets.gpu, work);
        const auto caster = engine->caster({}, prepared.budgets.gpu);
        caster->begin(raysOf(prepared.p));
        std::mutex mutex;
        std::vector<double> shares;
        Slicing slicing;
        slicing.fixedTile = 16;
        slicing.progress = [&](double share) {
            const std::lock_guard lock(mutex);
            shares.push_back(share);
        };
        EXPECT_TRUE(caster->draw(slicing, RayCaster::Clock::time_point::max(), work));
        ASSERT_FALSE(shares.empty());
        EXPECT_EQ(*std::max_element(shares.begin(), shares.end()), 1);
        EXPECT_GE(*std::min_element(shares.begin(), shares.end()), 0);
        if (engine == &gpu) {
            EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
            for (const int area : {256, 512, 640, 896, 1152, 1280, 1360, 1440, 1480})
                EXPECT_TRUE(std::binary_search(shares.begin(), shares.end(), area / (40.0 * 37))) << area;
        }
        engine->close();
    }
}

} // namespace
} // namespace tessera
