// tests/render/picture/tiles_test.cpp: a picture that is drawn tile by tile has the bits of one that is drawn
// as a whole, in whatever order and by however many, and its errors are measured as those of the whole.
#include "render/picture/render_scene.h"
#include "tests/support/scene_fixture.h"

#include <algorithm>
#include <functional>
#include <gmock/gmock.h>
#include <map>
#include <numeric>
#include <set>
#include <utility>

namespace tessera::test {
namespace {

/// Tiles in memory.
class KeptTiles : public PictureTiles {
  public:
    KeptTiles(const glm::ivec2& size, int side)
        : grid(size, side), colours(size), added(size), offsets(size) {
        for (std::size_t n = 0; n < grid.count(); ++n)
            left.push_back(n);
    }
    int side() const override { return grid.side(); }
    void begin(const Parts& plan) override { parts = plan; }
    std::optional<PictureTile> next() override {
        if (left.empty())
            return std::nullopt;
        const std::size_t number = left.back();
        left.pop_back();
        return grid.at(number);
    }
    void keep(const DrawnTile& drawn) override {
        EXPECT_EQ(drawn.colours.size, drawn.tile.size);
        ++kept;
        const auto put = [&](const Image& from, Image& to) {
            for (int y = 0; !from.pixels.empty() && y < drawn.tile.size.y; ++y)
                for (int x = 0; x < drawn.tile.size.x; ++x)
                    to.at(drawn.tile.from.x + x, drawn.tile.from.y + y) = from.at(x, y);
        };
        put(drawn.colours, colours);
        put(drawn.added, added);
        put(drawn.offsets, offsets);
    }
    double share() const override { return static_cast<double>(kept) / static_cast<double>(grid.count()); }
    bool finishes() const override { return isMine; }
    std::size_t shown() const override {
        return static_cast<std::size_t>(std::count_if(colours.pixels.begin(), colours.pixels.end(),
                                                      [](const glm::vec4& p) { return p.a > 1.0f / 255; }));
    }
    glm::vec4 colour(const glm::ivec2& pixel) const override { return colours.at(pixel.x, pixel.y); }
    void eachPixel(const std::function<void(const glm::vec4&, const glm::vec4&)>& visit) const override {
        for (std::size_t i = 0; i < colours.pixels.size(); ++i)
            visit(colours.pixels[i], offsets.pixels[i]);
    }
    /// As the picture shows it.
    Image image(bool lit) const {
        Image out = colours;
        for (std::size_t i = 0; lit && i < out.pixels.size(); ++i)
            out.pixels[i] = glm::max(out.pixels[i] + added.pixels[i], glm::vec4(0));
        return out;
    }
    TileGrid grid;
    Image colours, added, offsets;
    std::vector<std::size_t> left; // the last is next
    std::size_t kept = 0;
    bool isMine = true;
    Parts parts;
};

constexpr glm::ivec2 kTiled(83, 61);

struct TiledScene {
    const char* name;
    EngineKind engine;
    int camera;
    void (*change)(Scene&);
};

void takeSurfaces(Scene& scene, const std::vector<double>& values) {
    scene.mode = Mode::isosurface;
    for (const double value : values) {
        Isosurface surface;
        surface.value = value;
        surface.opacity = 0.6;
        scene.surfaces.push_back(surface);
    }
}

class Tiles : public ::testing::Test {
  protected:
    static RenderResult draw(const Scene& scene, RenderOptions options, PictureTiles* tiles,
                             std::size_t ramBytes = std::size_t{512} << 20) {
        MemoryBudget ram("RAM", "--ram", ramBytes), gpu("GPU memory", "--gpu-memory", std::size_t{256} << 20);
        const StoreReader store(storePath("torso"), ram);
        options.tiles = tiles;
        RenderResult result = renderScene(scene, store, ram, gpu, options);
        EXPECT_LE(ram.peakBytes(), ram.limitBytes());
        return result;
    }
    static RenderOptions optionsOf(const TiledScene& row) {
        RenderOptions options;
        options.engine = row.engine;
        options.device.text = "software";
        options.searching = true;
        return options;
    }
    static Scene sceneOf(const TiledScene& row) {
        MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20);
        const StoreReader store(storePath("torso"), ram);
        Scene scene = sceneOn(store.info(), "bone-1", row.camera, kTiled);
        scene.quality.automaticStep = true;
        scene.quality.pixels.samples = 1;
        row.change(scene);
        return scene;
    }
};

class TilesOf : public Tiles, public ::testing::WithParamInterface<TiledScene> {};

TEST_P(TilesOf, HaveTheBitsOfTheWhole) {
    const TiledScene& row = GetParam();
    const Scene scene = sceneOf(row);
    const RenderOptions options = optionsOf(row);
    const RenderResult whole = draw(scene, options, nullptr);
    ASSERT_FALSE(isBlank(whole.image));
    for (const int side : {16, 37, 100}) { // the last: one tile
        KeptTiles tiles(kTiled, side);
        const RenderResult result = draw(scene, options, &tiles);
        EXPECT_TRUE(result.image.pixels.empty());
        EXPECT_EQ(tiles.kept, tiles.grid.count());
        EXPECT_TRUE(bitEqual(tiles.image(scene.lighting.surfaceOcclusion || reflects(scene)), whole.image))
            << row.name << ", tiles of " << side;
        EXPECT_EQ(result.stepVoxels, whole.stepVoxels);
        EXPECT_EQ(result.bricksOfLevel, whole.bricksOfLevel);
        EXPECT_EQ(result.pixels.taken, whole.pixels.taken);
        ASSERT_EQ(result.pixels.error.has_value(), whole.pixels.error.has_value());
        if (whole.pixels.error) {
            EXPECT_EQ(result.pixels.error->rms, whole.pixels.error->rms);
            EXPECT_EQ(result.pixels.error->luvP99, whole.pixels.error->luvP99);
        }
    }
}

// Of tiles in passes a process may have drawn one, or all: that decides nothing about the errors that it
// measures.
TEST_F(Tiles, QuickMeasuringHasTheSameRoomWhoeverDrew) {
    Scene scene = sceneOf({"Passes", EngineKind::native, 0, [](Scene&) {}});
    scene.imageSize = {512, 512};
    scene.quality.automaticStep = false;
    scene.quality.stepVoxels = 2;
    scene.quality.maxError = 0; // rays wait for bricks
    RenderOptions options;
    options.engine = EngineKind::native;
    options.verify = Verify::quick;
    const auto measured = [&](KeptTiles& tiles) {
        MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20), gpu("GPU memory", "--gpu-memory", 20 << 20);
        const StoreReader store(storePath("torso"), ram);
        options.tiles = &tiles;
        const RenderResult result = renderScene(scene, store, ram, gpu, options);
        return std::pair(result.measured->whyNot, result.passes);
    };
    KeptTiles all(scene.imageSize, 128);
    const auto [why, passes] = measured(all);
    EXPECT_GT(passes, 1);
    KeptTiles one = all;
    one.left = {5};
    EXPECT_EQ(measured(one).first, why);
    one.left = {};
    EXPECT_EQ(measured(one).first, why);
}

void unchanged(Scene&) {}
void takeSamples(Scene& scene, int count) {
    scene.quality.pixels.samples = count;
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, TilesOf,
    ::testing::Values(TiledScene{"Plain", EngineKind::native, 0, unchanged},
                      TiledScene{"Parallel", EngineKind::native, 1, unchanged},
                      TiledScene{"Inside", EngineKind::native, 2, unchanged},
                      TiledScene{"Mirror", EngineKind::mirror, 0, unchanged},
                      TiledScene{"Samples", EngineKind::native, 0, [](Scene& s) { takeSamples(s, 8); }},
                      TiledScene{"OddSamples", EngineKind::native, 1, [](Scene& s) { takeSamples(s, 7); }},
                      TiledScene{"WideFilter", EngineKind::native, 0,
                                 [](Scene& s) {
                                     takeSamples(s, 5);
                                     s.quality.pixels.filter = PixelFilter::gaussian;
                                 }},
                      TiledScene{"LitWithOcclusionAndShadows", EngineKind::native, 0,
                                 [](Scene& s) {
                                     takeSamples(s, 2);
                                     s.lighting.occlusion = Occlusion{};
                                     Light light;
                                     light.shadow = true;
                                     s.lighting.lights = {light};
                                 }},
                      TiledScene{"Isosurfaces", EngineKind::native, 0,
                                 [](Scene& s) {
                                     takeSurfaces(s, {-300, 200});
                                 }},
                      TiledScene{"OccludedIsosurfaces", EngineKind::native, 0,
                                 [](Scene& s) {
                                     takeSurfaces(s, {-300, 200});
                                     s.lighting.surfaceOcclusion = SurfaceOcclusion{.radiusMm = 90};
                                 }},
                      TiledScene{"IsosurfacesOccludedAtHalfOfThePixels", EngineKind::native, 0,
                                 [](Scene& s) {
                                     takeSurfaces(s, {-300, 200});
                                     s.lighting.surfaceOcclusion =
                                         SurfaceOcclusion{.radiusMm = 90, .scale = 2};
                                 }},
                      TiledScene{"OccludedIsosurfacesWithSamples", EngineKind::native, 1,
                                 [](Scene& s) {
                                     takeSurfaces(s, {-300});
                                     s.lighting.surfaceOcclusion = SurfaceOcclusion{.radiusMm = 90};
                                     takeSamples(s, 3);
                                     s.quality.pixels.filter = PixelFilter::gaussian;
                                 }},
                      TiledScene{"MirroringIsosurfaces", EngineKind::native, 0,
                                 [](Scene& s) {
                                     takeSurfaces(s, {200});
                                     s.surfaces[0].opacity = 1;
                                     s.surfaces[0].reflection = Reflection{};
                                     takeSamples(s, 2);
                                 }},
                      TiledScene{"Largest", EngineKind::native, 0, [](Scene& s) { s.mode = Mode::maximum; }},
                      TiledScene{"Means", EngineKind::native, 1, [](Scene& s) { s.mode = Mode::average; }},
                      TiledScene{"Gpu", EngineKind::gpu, 0,
                                 [](Scene& s) {
                                     takeSurfaces(s, {-300, 200});
                                     s.lighting.surfaceOcclusion = SurfaceOcclusion{.radiusMm = 90};
                                     takeSamples(s, 2);
                                 }},
                      TiledScene{"Paths", EngineKind::native, 0,
                                 [](Scene& s) {
                                     s.lighting.transport = Transport{.bounces = 2};
                                     takeSamples(s, 4);
                                 }},
                      TiledScene{"Slice", EngineKind::native, 0,
                                 [](Scene& s) {
                                     s.mode = Mode::slice;
                                     s.slice.orientation = Orientation::axial;
                                     s.camera = FittedView{};
                                 }}),
    [](const auto& info) { return std::string(info.param.name); });

/// What a picture's error is measured of are its own pixels, wherever they are.
TEST_F(Tiles, AreMeasuredAsTheWhole) {
    const TiledScene row{"", EngineKind::native, 0, [](Scene& s) { takeSamples(s, 2); }};
    const Scene scene = sceneOf(row);
    RenderOptions options = optionsOf(row);
    options.verify = Verify::quick;
    const RenderResult whole = draw(scene, options, nullptr);
    KeptTiles tiles(kTiled, 32), others(kTiled, 32);
    const RenderResult result = draw(scene, options, &tiles);
    ASSERT_TRUE(whole.measured && result.measured);
    ASSERT_TRUE(whole.measured->whyNot.empty() && result.measured->whyNot.empty());
    const auto expectSame = [](const std::optional<Estimate>& a, const std::optional<Estimate>& b) {
        ASSERT_TRUE(a && b);
        EXPECT_EQ(a->value, b->value);
        EXPECT_EQ(a->low, b->low);
        EXPECT_EQ(a->high, b->high);
    };
    expectSame(result.measured->all.rms, whole.measured->all.rms);
    expectSame(result.measured->all.luvMean, whole.measured->all.luvMean);
    EXPECT_EQ(result.measured->all.pixels, whole.measured->all.pixels);
    EXPECT_EQ(result.measured->all.shown, whole.measured->all.shown);
    others.isMine = false;
    EXPECT_FALSE(draw(scene, options, &others).measured) << "by another process";
    // Who draws few of the tiles, or none, has the same plan, and measures the same.
    KeptTiles rest = tiles;
    rest.left = {3};
    const RenderResult few = draw(scene, options, &rest);
    EXPECT_TRUE(bitEqual(rest.colours, whole.image));
    EXPECT_EQ(rest.parts, tiles.parts);
    expectSame(few.measured->all.rms, whole.measured->all.rms);
}

/// RAM that has no room for the picture has room for a tile.
TEST_F(Tiles, TakeTheMemoryOfOne) {
    const TiledScene row{"", EngineKind::native, 1, unchanged};
    Scene scene = sceneOf(row);
    scene.imageSize = {2000, 1500};
    scene.camera = FittedView{};
    const std::size_t little = std::size_t{96} << 20;
    EXPECT_THROW(draw(scene, optionsOf(row), nullptr, little), InputError);
    KeptTiles tiles(scene.imageSize, 64);
    tiles.left = {200, 201};
    draw(scene, optionsOf(row), &tiles, little);
    const Image whole = draw(scene, optionsOf(row), nullptr).image;
    for (const std::size_t number : {200, 201}) {
        const PictureTile tile = tiles.grid.at(number);
        for (int y = 0; y < tile.size.y; ++y)
            for (int x = 0; x < tile.size.x; ++x) {
                const glm::ivec2 at = tile.from + glm::ivec2(x, y);
                ASSERT_EQ(tiles.colours.at(at.x, at.y), whole.at(at.x, at.y)) << at.x << " " << at.y;
            }
    }
}

TEST_F(Tiles, OtherPlansHaveOtherParts) {
    const TiledScene row{"", EngineKind::native, 0, unchanged};
    const auto partsOf = [&](void (*change)(Scene&)) {
        Scene scene = sceneOf(row);
        change(scene);
        KeptTiles tiles(kTiled, 50);
        tiles.left = {};
        draw(scene, optionsOf(row), &tiles);
        return tiles.parts;
    };
    const auto parts = partsOf(unchanged);
    EXPECT_EQ(partsOf(unchanged), parts);
    EXPECT_NE(partsOf([](Scene& s) {
                  s.quality.automaticStep = false;
                  s.quality.stepVoxels = 0.77;
              }),
              parts);
    EXPECT_NE(partsOf([](Scene& s) { s.quality.integrator = Integrator::preintegrated; }), parts);
}

TEST(TileGrids, CoverAPictureOnce) {
    for (const glm::ivec2 size : {glm::ivec2(1, 1), {64, 64}, {65, 63}, {200, 7}})
        for (const int side : {1, 16, 64, 300}) {
            const TileGrid grid(size, side);
            std::vector<int> seen(static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y), 0);
            for (std::size_t n = 0; n < grid.count(); ++n) {
                const PictureTile tile = grid.at(n);
                const std::vector<glm::vec2> middles = tile.middles();
                EXPECT_EQ(middles.size(), tile.pixels());
                for (const glm::vec2& place : middles) {
                    const glm::ivec2 at(place);
                    EXPECT_EQ(place, glm::vec2(at) + 0.5f);
                    EXPECT_EQ(grid.numberOf(at), n);
                    ++seen[static_cast<std::size_t>(at.y * size.x + at.x)];
                }
                const PictureTile wide = tile.with(5, size);
                EXPECT_EQ(glm::max(wide.from, glm::ivec2(0)), wide.from);
                EXPECT_EQ(glm::min(wide.from + wide.size, size), wide.from + wide.size);
                EXPECT_EQ(glm::max(tile.from - wide.from, tile.from + tile.size - wide.from - wide.size),
                          glm::min(tile.from, glm::ivec2(5)));
            }
            EXPECT_EQ(std::set<int>(seen.begin(), seen.end()), std::set<int>{1});
        }
}

} // namespace
} // namespace tessera::test
