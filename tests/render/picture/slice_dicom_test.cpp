// tests/render/picture/slice_dicom_test.cpp: slices of a DICOM series are trilinear interpolation of the
// values in its files, at the positions in the files. The test uses no code of this project except the
// program's own import and picture.
#include "bricking/import/importer.h"
#include "bricking/import/open_source.h"
#include "render/picture/render_scene.h"
#include "tests/support/dicom_writer.h"
#include "tests/support/import_test_tools.h"
#include "tests/support/scene_fixture.h"
#include "tests/support/value_scenes.h" // greyOf

#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <vector>

namespace tessera::test {
namespace {

constexpr int kColumns = 44, kRows = 37, kSlices = 40; // more than one brick, each way
constexpr double kDx = 0.8, kDy = 1.1, kDz = 1.5, kLow = -1000, kHigh = 2000;

/// A series that lies obliquely in the patient.
struct Series {
    glm::dvec3 row{0.9848077530122080, 0.1736481776669303, 0},
        column{-0.1736481776669303, 0.9848077530122080, 0};
    glm::dvec3 slice{0, 0, 1}, first{-11, 23, 40};
    std::vector<double> values;

    Series() {
        std::mt19937 random(3);
        for (int n = 0; n < kColumns * kRows * kSlices; ++n)
            values.push_back(kLow + static_cast<double>(random() % 3001));
        values[0] = kLow, values[1] = kHigh;
    }
    void write(const std::filesystem::path& folder) const {
        std::filesystem::create_directories(folder);
        for (int z = 0; z < kSlices; ++z) {
            DicomImage image;
            image.columns = kColumns, image.rows = kRows;
            image.rowDirection = row, image.columnDirection = column;
            image.spacingX = kDx, image.spacingY = kDy;
            image.position = first + static_cast<double>(z) * kDz * slice;
            for (int n = 0; n < kColumns * kRows; ++n)
                image.pixels.push_back(static_cast<std::uint16_t>(
                    values[static_cast<std::size_t>(z * kColumns * kRows + n)] + 1024));
            writeDicom(folder / (std::to_string(z) + ".dcm"), image);
        }
    }
    /// Of a place in the patient, in columns, rows and slices from the first voxel's middle.
    glm::dvec3 placeOf(const glm::dvec3& mm) const {
        return {glm::dot(mm - first, row) / kDx, glm::dot(mm - first, column) / kDy,
                glm::dot(mm - first, slice) / kDz};
    }
    static bool holds(const glm::dvec3& p, double margin) {
        return p.x > -0.5 + margin && p.y > -0.5 + margin && p.z > -0.5 + margin &&
               p.x < kColumns - 0.5 - margin && p.y < kRows - 0.5 - margin && p.z < kSlices - 0.5 - margin;
    }
    double at(const glm::dvec3& place) const {
        const glm::dvec3 last(kColumns - 1, kRows - 1, kSlices - 1),
            p = glm::clamp(place, glm::dvec3(0), last);
        const glm::dvec3 low = glm::min(glm::floor(p), last - 1.0), f = p - low;
        double sum = 0;
        for (int dz = 0; dz < 2; ++dz)
            for (int dy = 0; dy < 2; ++dy)
                for (int dx = 0; dx < 2; ++dx)
                    sum += (dx ? f.x : 1 - f.x) * (dy ? f.y : 1 - f.y) * (dz ? f.z : 1 - f.z) *
                           values[static_cast<std::size_t>(((low.z + dz) * kRows + low.y + dy) * kColumns +
                                                           low.x + dx)];
        return sum;
    }
};

class SliceOfDicom : public testing::TestWithParam<EngineKind> {
  protected:
    static void SetUpTestSuite() {
        const Series series;
        series.write(folder() / "dicom");
        MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20);
        const auto source = openSource(folder() / "dicom", {});
        ImportOptions options;
        options.force = true;
        options.durable = false;
        importToStore(*source, folder() / "s.zarr", ram, options);
    }
    static void TearDownTestSuite() { std::filesystem::remove_all(folder()); }
    static std::filesystem::path folder() {
        return std::filesystem::temp_directory_path() / ("tessera-slices-" + std::to_string(getpid()));
    }
};
INSTANTIATE_TEST_SUITE_P(Engines, SliceOfDicom,
                         testing::Values(EngineKind::native, EngineKind::mirror, EngineKind::gpu,
                                         EngineKind::reference),
                         [](const auto& info) { return std::string(name(info.param)); });

/// Of a plane's picture: where its pixels' middles lie, by radiology's custom.
struct Seen {
    SlicePlane plane;
    glm::dvec3 right, up, normal;
};

TEST_P(SliceOfDicom, IsTrilinearInterpolationOfItsValues) {
    const Series series;
    const glm::dvec3 oblique = glm::normalize(glm::dvec3(0.2, -0.7, 0.5));
    const glm::dvec3 obliqueRight = glm::normalize(glm::cross(-oblique, glm::dvec3(0, 0, 1)));
    const std::vector<Seen> all = {{{Orientation::axial, 71.3}, {1, 0, 0}, {0, -1, 0}, {0, 0, -1}},
                                   {{Orientation::coronal, 40.05}, {1, 0, 0}, {0, 0, 1}, {0, -1, 0}},
                                   {{Orientation::sagittal, 3.7}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}},
                                   {{Orientation::oblique, {}, {2, 41, 66}, oblique},
                                    obliqueRight,
                                    glm::cross(obliqueRight, -oblique),
                                    oblique}};
    for (const Seen& seen : all) {
        Scene scene;
        scene.volumes.push_back({folder() / "s.zarr"});
        scene.mode = Mode::slice;
        scene.slice = seen.plane;
        scene.window = GreyWindow{0.5 * (kLow + kHigh), kHigh - kLow};
        scene.imageSize = {120, 90};
        scene.quality.fetch = Fetch::exact;
        MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20),
            gpu("GPU memory", "--gpu-memory", std::size_t{256} << 20);
        const StoreReader reader(folder() / "s.zarr", ram);
        RenderOptions options;
        options.engine = GetParam();
        options.device.text = "software";
        const RenderResult result = renderScene(scene, reader, ram, gpu, options);
        EXPECT_EQ(result.level, 0);
        const Camera& camera = result.camera;
        EXPECT_EQ(camera.projection, Projection::parallel);
        int inside = 0;
        double worst = 0;
        for (int y = 0; y < 90; ++y)
            for (int x = 0; x < 120; ++x) {
                const double a = (2 * (x + 0.5) / 120 - 1) * camera.parallelScale * 120 / 90,
                             b = (1 - 2 * (y + 0.5) / 90) * camera.parallelScale;
                const glm::dvec3 mm = camera.focalPoint + a * seen.right + b * seen.up;
                const glm::dvec3 place = series.placeOf(mm);
                const glm::vec4 pixel = result.image.at(x, y);
                if (!Series::holds(place, 1e-4)) {
                    if (!Series::holds(place, -1e-4)) {
                        EXPECT_EQ(pixel.a, 0) << x << " " << y;
                    }
                    continue;
                }
                ++inside;
                ASSERT_EQ(pixel.a, 1) << x << " " << y;
                const double grey = (series.at(place) - kLow) / (kHigh - kLow);
                worst = std::max(worst, std::abs(greyOf(static_cast<double>(pixel.g)) - grey));
            }
        EXPECT_GT(inside, 3000);
        EXPECT_LT(worst, 1e-5) << orientationNames()[static_cast<std::size_t>(seen.plane.orientation)];
    }
}

} // namespace
} // namespace tessera::test
