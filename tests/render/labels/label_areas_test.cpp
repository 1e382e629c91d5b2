// tests/render/labels/label_areas_test.cpp: 117 labels that are known shapes: the area that each covers in a
// picture, with ample memory and with the least. None is lost.
#include "render/picture/render_scene.h"
#include "tests/support/formula_source.h"
#include "tests/support/labelled.h"

#include <cmath>
#include <gtest/gtest.h>
#include <set>
#include <utility>

namespace tessera {
namespace {

using namespace tessera::test;

/// Balls, rods and plates on a grid, voxels of 1 mm, seen along y.
struct Shape {
    glm::dvec3 centre;
    int kind = 0; // ball, rod along x, plate across y
    double size = 0;
    bool holds(const glm::dvec3& p) const {
        const glm::dvec3 d = glm::abs(p - centre);
        if (kind == 0)
            return glm::dot(d, d) < size * size;
        if (kind == 1)
            return d.x < 8 && d.y * d.y + d.z * d.z < size * size;
        return d.x < size && d.y < 1 && d.z < 5;
    }
};

std::vector<Shape> shapes() {
    constexpr int kAlong = 5, kLabels = 117;
    std::vector<Shape> all;
    for (int n = 0; n < kLabels; ++n) {
        const glm::dvec3 cell(n % kAlong, n / kAlong % kAlong, n / (kAlong * kAlong));
        const glm::dvec3 off = glm::fract(glm::dvec3(0.37, 0.61, 0.83) * double(n));
        all.push_back({24.0 * cell + 11.5 + off, n % 3,
                       n % 3 == 0   ? 3 + 0.5 * (n % 12)
                       : n % 3 == 1 ? 1.5 + 0.5 * (n % 4)
                                    : 3.0 + n % 6});
    }
    return all;
}

TEST(LabelAreas, OfEveryLabelAreTrue) {
    VolumeInfo info;
    info.extentVoxels = glm::ivec3(120);
    info.unit = "HU";
    info.patientFromVoxel = glm::dmat4(1);
    const ScratchFolder folder;
    MemoryBudget ram("RAM", "--ram", std::size_t{1} << 30);
    FormulaSource source(info, [](const glm::dvec3& p) { return -1000 + 10 * p.x; });
    importToStore(source, folder / "v.zarr", ram, {});
    const std::vector<Shape> all = shapes();
    HeldLayer layer(info, Values(cellCount(info.extentVoxels)));
    for (std::size_t i = 0; i < layer.values.size(); ++i) {
        const glm::dvec3 p = glm::dvec3(gridPosition(i, info.extentVoxels)) + 0.5;
        const glm::ivec3 cell = glm::ivec3(p) / 24;
        const int n = cell.x + 5 * cell.y + 25 * cell.z;
        if (n < static_cast<int>(all.size()) && all[static_cast<std::size_t>(n)].holds(p))
            layer.values[i] = static_cast<std::uint32_t>(n) + 1;
    }
    LabelFile file = fileOf({layer});
    importLabels(file, info, folder / "l.zarr", ram, quickly());
    const StoreReader store(folder / "v.zarr", ram);
    constexpr double kPixel = 0.5;                            // mm
    constexpr std::size_t kLeastBytes = std::size_t{2} << 20; // level 1, or one brick of level 0
    // Pixels of half a millimetre, seen along y without perspective.
    Scene scene = sceneOn(info, "bone-1", 0, {240, 240});
    Camera camera = fitCamera(info, View::anterior, Projection::parallel, scene.imageSize);
    camera.parallelScale = 60;
    scene.camera = camera;
    scene.shading.on = false;
    scene.quality.terminationTransmittance = 1.0 / 510;
    scene.quality.integrator = Integrator::automatic;
    label(scene, folder / "l.zarr");
    const auto areaOf = [&](std::size_t number, std::size_t gpuBytes) {
        scene.volumes[0].labels.show = {std::to_string(number + 1)};
        MemoryBudget gpu("GPU memory", "--gpu-memory", gpuBytes);
        RenderOptions options;
        options.engine = EngineKind::native;
        options.verify = Verify::none;
        const RenderResult result = renderScene(scene, store, ram, gpu, options);
        double area = 0;
        for (const glm::vec4& pixel : result.image.pixels)
            area += static_cast<double>(pixel.a) * kPixel * kPixel;
        return area;
    };
    // The voxels of a shape cover their columns.
    std::vector<std::set<std::pair<int, int>>> columns(all.size());
    for (std::size_t i = 0; i < layer.values.size(); ++i)
        if (const std::uint32_t value = layer.values[i]; value > 0) {
            const glm::ivec3 at = gridPosition(i, info.extentVoxels);
            columns[value - 1].insert({at.x, at.z});
        }
    std::size_t ampleMisses = 0, leastMisses = 0;
    for (std::size_t n = 0; n < all.size(); ++n) {
        SCOPED_TRACE(testing::Message()
                     << "label " << n + 1 << ", kind " << all[n].kind << ", size " << all[n].size);
        const auto truth = static_cast<double>(columns[n].size());
        const double ample = areaOf(n, std::size_t{1} << 30), least = areaOf(n, kLeastBytes);
        EXPECT_NEAR(ample, truth, std::max(0.02 * truth, 3.7)); // corners of a voxel are rounded
        EXPECT_NEAR(least, truth, std::max(0.17 * truth, 4.0));
        ampleMisses += std::abs(ample - truth) > std::max(0.02 * truth, 1.0) ? 1 : 0;
        leastMisses += std::abs(least - truth) > std::max(0.1 * truth, 2.0) ? 1 : 0;
    }
    EXPECT_LE(ampleMisses, 6u);
    EXPECT_LE(leastMisses, 10u);
}

} // namespace
} // namespace tessera
