// tests/render/labels/label_mask_test.cpp: labels that are hidden from rays that keep one value: the picture
// of a volume that never held what they hide.
#include "bricking/import/importer.h"
#include "core/base/program_folders.h"
#include "core/image/image_metrics.h"
#include "render/labels/label_mask.h"
#include "render/picture/render_scene.h"
#include "tests/support/bricking_test_volumes.h"
#include "tests/support/label_tools.h"
#include "tests/support/native_fixture.h"
#include "tests/support/refusals.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace tessera::test;

constexpr glm::ivec3 kExtent(70, 44, 51);

std::uint32_t labelAt(const glm::ivec3& p) {
    const glm::dvec3 d = glm::dvec3(p) - glm::dvec3(24, 20, 26);
    if (glm::dot(d, d) < 15 * 15)
        return 1;
    return p.x > 45 && p.x < 60 && p.y % 9 < 2 ? 2 : p == glm::ivec3(40, 5, 7) ? 3 : 0;
}
/// Labels are brighter than all else, but half of the ball, which is darker.
double valueAt(const glm::ivec3& p) {
    const std::uint32_t label = labelAt(p);
    return std::round(300 + 250 * std::sin(0.3 * p.x) * std::cos(0.23 * p.y + 1) * std::sin(0.19 * p.z)) +
           (label == 0               ? 0
            : label == 1 && p.x > 24 ? -350
                                     : 400);
}
constexpr double kLeast = -400, kGreatest = 990;

VolumeInfo scanInfo(double slope) {
    VolumeInfo info;
    info.type = ValueType::i16;
    info.extentVoxels = kExtent;
    info.rescaleSlope = slope;
    info.patientFromVoxel = patientFromVoxelOf({0, 0, 0}, {1.2, 0, 0}, {0, 1, 0}, {0, 0, 0.9});
    return info;
}

/// A scan with a slope, the same without what some labels hide, and the labels.
struct Scan {
    ScratchFolder folder;
    std::filesystem::path store = folder / "scan.zarr", labels = folder / "labels.zarr";
    double slope;
    explicit Scan(double slopeOf) : slope(slopeOf) {
        MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20);
        write(store, [](const glm::ivec3& p) { return valueAt(p); });
        std::vector<std::uint32_t> values(cellCount(kExtent));
        for (std::size_t i = 0; i < values.size(); ++i)
            values[i] = labelAt(gridPosition(i, kExtent));
        HeldLayer layer(scanInfo(slope), std::move(values));
        LabelFile file = fileOf({layer}, {{1, "ball"}, {2, "bars"}, {3, "dot"}});
        importLabels(file, scanInfo(slope), labels, ram, quickly());
    }
    void write(const std::filesystem::path& to, const std::function<double(const glm::ivec3&)>& value) const {
        MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20);
        HashSource source(scanInfo(slope), [&](int x, int y, int z) {
            const glm::ivec3 p(x, y, z); // the range is the same whatever is hidden
            return (p == glm::ivec3(0) ? kLeast : p == glm::ivec3(1, 0, 0) ? kGreatest : value(p)) / slope;
        });
        importToStore(source, to, ram, {});
    }
    Image picture(const std::filesystem::path& path, Scene scene, EngineKind engine) const {
        MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20),
            gpu("GPU memory", "--gpu-memory", std::size_t{512} << 20);
        const StoreReader reader(path, ram);
        RenderOptions options;
        options.engine = engine;
        options.device.text = "software";
        options.levels = LevelChoice::oneForAll;
        return renderScene(scene, reader, ram, gpu, options).image;
    }
};

Scene sceneOf(const Scan& scan, Mode mode) {
    Scene scene = sceneOn(scanInfo(scan.slope), "auto", 0, {40, 36});
    scene.mode = mode;
    scene.window = GreyWindow{300, 1400};
    if (mode == Mode::isosurface)
        scene.surfaces = {{450, {1, 0.8, 0.6}, 0.6}, {120, {0.4, 0.7, 1}, 0.5}};
    return scene;
}

class HiddenLabels : public testing::TestWithParam<Mode> {};
INSTANTIATE_TEST_SUITE_P(Modes, HiddenLabels,
                         testing::Values(Mode::maximum, Mode::minimum, Mode::average, Mode::isosurface));

TEST_P(HiddenLabels, AreThePictureOfAVolumeWithoutThem) {
    for (const double slope : {1.0, -2.0}) {
        const Scan scan(slope);
        for (const bool isolates : {false, true}) {
            Scene scene = sceneOf(scan, GetParam());
            const double instead = GetParam() == Mode::minimum ? kGreatest : kLeast;
            const std::filesystem::path without = scan.folder / (isolates ? "alone.zarr" : "without.zarr");
            scan.write(without, [&](const glm::ivec3& p) {
                const std::uint32_t label = labelAt(p);
                const bool hidden = isolates ? label != 2 : label == 1 || label == 3;
                return hidden ? instead : valueAt(p);
            });
            Scene hiding = scene;
            Labels& labels = hiding.volumes[0].labels;
            labels.path = labels.store = scan.labels;
            if (isolates)
                labels.show = {"bars"};
            else
                labels.hide = {"ball", "3"};
            for (const EngineKind engine :
                 {EngineKind::native, EngineKind::mirror, EngineKind::reference, EngineKind::gpu}) {
                const Image as = scan.picture(without, scene, engine);
                EXPECT_EQ(differing(scan.picture(scan.store, hiding, engine), as), 0u)
                    << name(engine) << (isolates ? ", isolated" : "") << ", slope " << slope;
                EXPECT_GT(compare(scan.picture(scan.store, scene, engine), as).rms, 0.02) << name(engine);
            }
        }
    }
}

TEST(HiddenLabelsOf, NothingHiddenAreNone) {
    const Scan scan(1);
    Scene scene = sceneOf(scan, Mode::maximum), labelled = scene;
    labelled.volumes[0].labels.path = labelled.volumes[0].labels.store = scan.labels;
    EXPECT_EQ(differing(scan.picture(scan.store, labelled, EngineKind::native),
                        scan.picture(scan.store, scene, EngineKind::native)),
              0u);
    labelled.volumes[0].labels.hide = {"bal"};
    const std::string refusal = refusalOf([&] { scan.picture(scan.store, labelled, EngineKind::native); });
    EXPECT_NE(refusal.find("ball"), std::string::npos) << refusal;
}

TEST(HiddenLabelsOf, PartsAndSharesAreThoseOfTheVoxels) {
    const Scan scan(1);
    MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20);
    auto volume = std::make_unique<LabelVolume>(scan.labels, ram);
    LabelTable table = volume->table();
    std::vector<LabelFactors> factors(table.sets.size());
    for (std::size_t set = 0; set < factors.size(); ++set)
        for (const auto label : table.sets[set])
            if (table.labels[label].value == 1)
                factors[set] = {.plain = 0};
    const LabelMask mask(std::make_unique<DrawnLabels>(std::move(volume), table, factors, 0.0f));
    for (int level = 0; level <= 3; ++level) {
        const glm::ivec3 extent = levelExtent(kExtent, level);
        for (std::size_t n = 0; n < cellCount(ceilDiv(extent, kChunkExtent)); ++n) {
            const glm::ivec3 first = gridPosition(n, ceilDiv(extent, kChunkExtent)) * kChunkExtent;
            const glm::ivec3 count = glm::min(extent - first, glm::ivec3(kChunkExtent));
            std::vector<float> shares(cellCount(count));
            mask.read(level, first, count, shares);
            double most = 0;
            for (std::size_t i = 0; i < shares.size(); ++i) {
                const glm::ivec3 low = (first + gridPosition(i, count)) << level,
                                 high = glm::min(low + (1 << level), kExtent);
                int hidden = 0;
                for (int z = low.z; z < high.z; ++z)
                    for (int y = low.y; y < high.y; ++y)
                        for (int x = low.x; x < high.x; ++x)
                            hidden += labelAt({x, y, z}) == 1;
                const double share = hidden / static_cast<double>(cellCount(high - low));
                most = std::max(most, std::abs(share - static_cast<double>(shares[i])));
            }
            EXPECT_LT(most, 1e-4) << level;
        }
    }
    EXPECT_EQ(mask.of({20, 16, 22}, {28, 24, 30}), HiddenPart::Part::all);
    EXPECT_EQ(mask.of({60, 0, 0}, {70, 8, 8}), HiddenPart::Part::none);
    EXPECT_EQ(mask.of({0, 0, 0}, kExtent), HiddenPart::Part::some);
}

} // namespace
} // namespace tessera
