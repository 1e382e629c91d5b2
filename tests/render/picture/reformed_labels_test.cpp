// tests/render/picture/reformed_labels_test.cpp: labels over reformations: those of slices where the line is
// straight, bars along a bent one, and the same bits whatever draws them.
#include "core/animation/reformed_line.h"
#include "core/base/program_folders.h"
#include "core/scene/reformed_sheet.h"
#include "render/contract/lattice.h"
#include "render/picture/reformed_picture.h"
#include "tests/support/curves.h"
#include "tests/support/formula_source.h"
#include "tests/support/labelled.h"

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <numbers>
#include <vector>

namespace tessera::test {
namespace {

/// Waves of values around the origin in voxels of 1 x 1 x 1.5 mm, and labels that are a formula of places.
struct LabelledField {
    static constexpr glm::ivec3 kExtent{90, 96, 60};
    explicit LabelledField(const std::function<std::uint32_t(const glm::dvec3&)>& at) {
        info.extentVoxels = kExtent;
        info.patientFromVoxel = glm::dmat4(1);
        info.patientFromVoxel[2][2] = 1.5;
        info.patientFromVoxel[3] = {-45, -48, -45, 1};
        const auto placeOf = [this](const glm::dvec3& voxel) {
            return glm::dvec3(info.patientFromVoxel * glm::dvec4(voxel, 1));
        };
        FormulaSource source(info, [&](const glm::dvec3& voxel) {
            const glm::dvec3 mm = placeOf(voxel);
            return 400 + 300 * std::sin(mm.x / 7 + mm.y / 5 + mm.z / 9);
        });
        importToStore(source, store, ram, {});
        Values values(cellCount(kExtent));
        for (std::size_t i = 0; i < values.size(); ++i)
            values[i] = at(placeOf(glm::dvec3(gridPosition(i, kExtent)) + 0.5));
        LabelFile file = fileOf({HeldLayer(info, std::move(values))});
        importLabels(file, info, labels, ram, quickly());
        scene.volumes.resize(1);
        scene.volumes[0].transferFunction = std::string("auto");
        scene.mode = Mode::slice;
        scene.window = GreyWindow{400, 800};
        label(scene, labels);
    }
    RenderResult draw(std::vector<Reformation> pictures, int threads = 0, MemoryBudget* budget = nullptr) {
        layOutPictures(pictures);
        MemoryBudget& taken = budget ? *budget : ram;
        const StoreReader reader(store, taken);
        RenderOptions options;
        options.threads = threads;
        ReformedShare share;
        return renderReformed(scene, pictures, reader, taken, options, share);
    }

  private:
    const tessera::ScratchFolder folder_;

  public:
    VolumeInfo info;
    Scene scene;
    MemoryBudget ram{"RAM", "--ram", std::size_t{512} << 20},
        gpu{"GPU memory", "--gpu-memory", std::size_t{512} << 20};
    const std::filesystem::path store = folder_ / "v.zarr", labels = folder_ / "l.zarr";
};

std::uint32_t balls(const glm::dvec3& mm) {
    return glm::length(mm) < 9                            ? 1
           : glm::distance(mm, {12, 6, 5}) < 10           ? 2
           : std::abs(mm.x + mm.y + mm.z) < 4 && mm.x < 0 ? 7
                                                          : 0;
}

TEST(ReformedLabels, OfAStraightLineAreTheSlices) {
    LabelledField field(balls);
    const glm::dvec3 along(0.6, 0, 0.8);
    const FlightCurve line = curveOf(50, [&](double mm) { return (mm - 25) * along; });
    for (const auto& [borders, outline] :
         {std::pair{LabelBorders::smooth, 2.5}, {LabelBorders::nearest, 1.0}}) {
        Labels& labels = field.scene.volumes[0].labels;
        labels.borders = borders, labels.outline = outline, labels.fill = 0.4;
        for (const double degrees : {0.0, 70.0})
            for (const Reformation& picture :
                 {straightened(line, degrees, {30, 0.5, 1}), crossSection(line, 24, degrees, {30, 0.5, 1})}) {
                const RenderResult drawn = field.draw({picture});
                const ReformedRow& first = picture.rows.front();
                const glm::dvec3 down = glm::normalize(picture.rows.back().at - first.at);
                Scene scene = field.scene;
                scene.quality.pixels.samples = 1;
                scene.quality.fetch = Fetch::exact;
                scene.imageSize = picture.size();
                Camera camera;
                camera.projection = Projection::parallel;
                camera.focalPoint = first.at + (0.25 * picture.size().y - 0.25) * down;
                camera.position = camera.focalPoint + 100.0 * first.towards;
                camera.viewUp = -down;
                camera.parallelScale = 0.25 * picture.size().y;
                scene.camera = camera;
                scene.slice = {Orientation::oblique, {}, camera.focalPoint, first.towards};
                RenderOptions options;
                options.engine = EngineKind::native;
                const StoreReader reader(field.store, field.ram);
                const RenderResult slice = renderScene(scene, reader, field.ram, field.gpu, options);
                ASSERT_EQ(slice.image.size, drawn.image.size);
                std::size_t coloured = 0;
                for (std::size_t n = 0; n < slice.image.pixels.size(); ++n) {
                    const glm::vec4 &one = drawn.image.pixels[n], &other = slice.image.pixels[n];
                    ASSERT_LT(glm::distance(one, other), 2e-5F) << n;
                    coloured += one.r != one.g || one.g != one.b;
                }
                EXPECT_GT(coloured, 300U);
                ASSERT_TRUE(drawn.labels && slice.labels);
                EXPECT_EQ(drawn.labels->onSlice, slice.labels->onSlice);
                EXPECT_EQ(drawn.labels->level, slice.labels->level);
                EXPECT_EQ(drawn.labels->all, 3U);
            }
    }
}

// A tube around a circle is a bar of its width, as long as the circle.
TEST(ReformedLabels, OfATubeAreABar) {
    constexpr double kCircle = 24, kTube = 6;
    LabelledField field([](const glm::dvec3& mm) {
        return std::hypot(std::hypot(mm.x, mm.y) - kCircle, mm.z) < kTube ? 1U : 0U;
    });
    field.scene.window = GreyWindow{5000, 10}; // black
    Labels& labels = field.scene.volumes[0].labels;
    labels.fill = 1, labels.outline = 0, labels.each = {{"*", {}, {}, glm::dvec3(1, 0, 0)}};
    const FlightCurve line = curveOf(1.5 * std::numbers::pi * kCircle, [](double mm) {
        return glm::dvec3(kCircle * std::cos(mm / kCircle), kCircle * std::sin(mm / kCircle), 0);
    });
    std::vector<Reformation> pictures = {straightened(line, 20, {20, 0.4, 1}),
                                         straightened(line, 80, {20, 0.4, 2}),
                                         crossSection(line, 50, 0, {20, 0.4, 1})};
    const double bar = 2 * kTube * line.lengthMm() / (0.4 * 0.4),
                 disc = std::numbers::pi * kTube * kTube / (0.4 * 0.4);
    for (const Reformation& picture : pictures) {
        double red = 0;
        for (const glm::vec4& pixel : field.draw({picture}).image.pixels)
            red += static_cast<double>(pixel.r);
        const double expected = picture.isSection ? disc : bar;
        EXPECT_NEAR(red, expected, 0.02 * expected);
    }
    // Together, with few threads and little memory, the same bits.
    const Image ample = field.draw(pictures).image;
    EXPECT_EQ(ample.pixels, field.draw(pictures, 1).image.pixels);
    MemoryBudget scarce("RAM", "--ram", std::size_t{24} << 20);
    EXPECT_EQ(ample.pixels, field.draw(pictures, 2, &scarce).image.pixels);
    EXPECT_LE(scarce.peakBytes(), std::size_t{24} << 20);
}

} // namespace
} // namespace tessera::test
