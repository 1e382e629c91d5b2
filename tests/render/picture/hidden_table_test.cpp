// tests/render/picture/hidden_table_test.cpp: pictures without the table under a patient are those of a scan
// that never had one, whatever draws them.
#include "bricking/analysis/body/kept_table.h"
#include "core/base/program_folders.h"
#include "core/image/image_metrics.h"
#include "core/scene/scene_presets.h"
#include "render/picture/render_scene.h"
#include "tests/support/bricking_store_tools.h"
#include "tests/support/scene_fixture.h"

#include <cmath>

namespace tessera::test {
namespace {

constexpr glm::ivec3 kScanned{72, 80, 56};
constexpr double kAir = -1000;

double bodyHu(const glm::dvec3& p) {
    const double r = glm::length((p - glm::dvec3(36, 30, 28)) / glm::dvec3(30, 24, 40));
    return r < 1 ? std::floor(900 * (1 - r) + 60 * std::sin(0.7 * p.x) * std::cos(0.5 * p.z)) : kAir;
}
/// Whole cells: their samples of every level are hidden wholly, or of none.
bool isTable(const glm::ivec3& p) {
    return p.y / kCellExtent >= 8;
}

struct HiddenTable : ::testing::Test {
    ScratchFolder folder;
    Budgets budgets;
    std::unique_ptr<StoreReader> with, without;

    void SetUp() override {
        VolumeInfo info = plainInfo(kScanned, ValueType::i16);
        info.unit = "HU";
        info.patientFromVoxel = patientFromVoxelOf({0, 0, 0}, {1.5, 0, 0}, {0, 1.5, 0}, {0, 0, 2});
        for (const bool table : {true, false}) {
            const fs::path path = folder / (table ? "with.zarr" : "without.zarr");
            HashSource source(info, [table](int x, int y, int z) {
                const bool here = isTable({x, y, z});
                return here ? (table ? 300 + 40 * std::sin(x * 0.9) : kAir) : bodyHu(glm::dvec3(x, y, z));
            });
            import(path, source);
            (table ? with : without) = std::make_unique<StoreReader>(path, budgets.ram);
        }
        std::vector<std::uint8_t> shares(cellCount(kScanned));
        for (std::size_t i = 0; i < shares.size(); ++i)
            shares[i] = isTable(gridPosition(i, kScanned)) ? 255 : 0;
        FoundTable found;
        found.litres = 3;
        found.mask = std::make_shared<const Mask>(kScanned, 0, shares, budgets.ram);
        keepTable(found, *with, with->path());
    }
    Scene scene(HideTable hide) const {
        Scene s;
        s.volumes = {SceneVolume{}};
        s.volumes[0].transferFunction = TransferFunction::fromOpacity(
            {{-900, 0}, {-200, 0.2}, {700, 0.9}}, {{-200, {0.8, 0.5, 0.4}}, {700, {1, 1, 0.9}}}, 2);
        s.volumes[0].hideTable = hide;
        s.imageSize = {61, 53};
        s.camera = FittedView{View::left};
        s.quality.stepVoxels = 0.5;
        return s;
    }
    RenderResult draw(const Scene& s, const StoreReader& store, EngineKind engine) {
        RenderOptions options;
        options.engine = engine;
        options.threads = 2;
        return renderScene(s, store, budgets.ram, budgets.gpu, options);
    }
};

TEST_F(HiddenTable, IsAsIfItHadNeverBeenScanned) {
    struct Row {
        const char* name;
        void (*set)(Scene&);
    };
    const Row rows[] = {
        {"lit", [](Scene&) {}},
        {"unlit, nothing skipped", [](Scene& s) { s.shading.on = false, s.quality.skipping = false; }},
        {"studio", [](Scene& s) { applyLook("studio", s); }},
        {"greatest value", [](Scene& s) { s.mode = Mode::maximum; }},
        {"mean", [](Scene& s) { s.mode = Mode::average; }},
        {"a surface", [](Scene& s) { s.surfaces = {{200.0}}; }},
        {"an error bound", [](Scene& s) { s.quality.maxError = 1.0; }}};
    for (const Row& row : rows)
        for (const EngineKind engine : {EngineKind::native, EngineKind::mirror, EngineKind::reference}) {
            if (engine == EngineKind::reference && (row.set == rows[2].set || row.set == rows[6].set))
                continue; // minutes
            SCOPED_TRACE(std::string(row.name) + " " + name(engine));
            Scene hides = scene(HideTable::automatic), shows = scene(HideTable::no);
            row.set(hides), row.set(shows);
            const RenderResult a = draw(hides, *with, engine), b = draw(shows, *without, engine);
            EXPECT_EQ(a.camera.position, b.camera.position);
            // Maps of shadows are laid around what may show by the ranges of cells, which are wider beside
            // what is hidden.
            if (row.set == rows[2].set) {
                EXPECT_LT(compare(a.image, b.image).maxAbs, 0.004);
            } else {
                EXPECT_TRUE(a.image.pixels == b.image.pixels) << compare(a.image, b.image).maxAbs;
            }
            ASSERT_TRUE(a.patientTable);
            EXPECT_EQ(a.patientTable->why, "");
            EXPECT_EQ(a.patientTable->litres, 3);
            EXPECT_FALSE(b.patientTable);
        }
    const RenderResult shown = draw(scene(HideTable::no), *with, EngineKind::native);
    EXPECT_FALSE(shown.image.pixels ==
                 draw(scene(HideTable::automatic), *with, EngineKind::native).image.pixels);
}

// The plan of the picture takes the place of the first picture's, whose chunks are read on.
TEST_F(HiddenTable, IsHiddenBehindAFirstPicture) {
    const RenderResult alone = draw(scene(HideTable::automatic), *with, EngineKind::native);
    RenderOptions options;
    options.engine = EngineKind::native;
    options.threads = 2;
    for (int n = 0; n < 20; ++n) {
        int firsts = 0;
        options.onFirstPicture = [&](const Image&, double) { ++firsts; };
        const RenderResult after =
            renderScene(scene(HideTable::automatic), *with, budgets.ram, budgets.gpu, options);
        EXPECT_EQ(firsts, 1);
        EXPECT_TRUE(after.image.pixels == alone.image.pixels);
    }
}

TEST_F(HiddenTable, IsInSlices) {
    Scene a = scene(HideTable::automatic), b = scene(HideTable::no);
    a.mode = b.mode = Mode::slice;
    const RenderResult one = draw(a, *with, EngineKind::native), other = draw(b, *with, EngineKind::native);
    EXPECT_TRUE(one.image.pixels == other.image.pixels);
    EXPECT_FALSE(one.patientTable);
}

TEST_F(HiddenTable, IsHiddenInAnyBudgetOrTheReasonIsSaid) {
    const Scene s = scene(HideTable::automatic);
    const std::size_t floor = renderFloorBytes(with->info(), s.imageSize, kPictureBytesPerPixel, 2);
    bool hidden = false, shown = false;
    for (const double share : {1.0, 1.2, 1.6, 2.5, 6.0}) {
        MemoryBudget ram("RAM", "--ram", static_cast<std::size_t>(share * static_cast<double>(floor)));
        const StoreReader store(with->path(), ram);
        RenderOptions options;
        options.engine = EngineKind::native;
        options.threads = 2;
        options.verify = Verify::none;
        const RenderResult r = renderScene(s, store, ram, budgets.gpu, options);
        EXPECT_LE(ram.peakBytes(), ram.limitBytes());
        ASSERT_TRUE(r.patientTable);
        hidden |= r.patientTable->why.empty();
        shown |= r.patientTable->why.starts_with("--ram has no room for looking");
    }
    EXPECT_TRUE(hidden);
    EXPECT_TRUE(shown);
}

TEST_F(HiddenTable, OnlyOfValuesInHu) {
    VolumeInfo info = plainInfo(kScanned, ValueType::i16);
    HashSource source(info, [](int x, int y, int z) { return x + y + z; });
    import(folder / "plain.zarr", source);
    const StoreReader plain(folder / "plain.zarr", budgets.ram);
    EXPECT_FALSE(fs::exists(folder / "plain.zarr/stats/table"));
    EXPECT_TRUE(fs::exists(folder / "without.zarr/stats/table")); // found at import
    EXPECT_FALSE(draw(scene(HideTable::automatic), plain, EngineKind::native).patientTable);
}

} // namespace
} // namespace tessera::test
