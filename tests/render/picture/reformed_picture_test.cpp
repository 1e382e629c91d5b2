// tests/render/picture/reformed_picture_test.cpp: reformations of tubes whose walls lie at a known distance
// from their lines, in volumes of any spacing and orientation, and the same formula in double precision.
#include "render/picture/reformed_picture.h"

#include "bricking/import/importer.h"
#include "core/animation/reformed_line.h"
#include "core/base/error.h"
#include "core/base/program_folders.h"
#include "core/image/colour.h"
#include "core/scene/reformed_sheet.h"
#include "render/contract/lattice.h"
#include "tests/support/curves.h"
#include "tests/support/folders.h"
#include "tests/support/formula_source.h"

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <numbers>
#include <optional>
#include <utility>

namespace tessera::test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr GreyWindow kWindow{20, 40}; // distances from 0 to 40 mm

/// A volume whose values are a formula of the patient's mm, on a lattice of any shape around 0.
struct Field {
    Field(Formula ofMm, const glm::dmat3& voxel, const glm::ivec3& extent) : ofPatientMm(std::move(ofMm)) {
        info.extentVoxels = extent;
        info.type = ValueType::f32;
        info.patientFromVoxel = glm::dmat4(voxel);
        info.patientFromVoxel[3] = glm::dvec4(-(voxel * (0.5 * glm::dvec3(extent))), 1);
        FormulaSource source(info, stored());
        importToStore(source, folder / "field.zarr", ram, {});
        reader.emplace(folder / "field.zarr", ram);
    }
    Formula stored() const {
        return [this](const glm::dvec3& p) {
            return ofPatientMm(glm::dvec3(info.patientFromVoxel * glm::dvec4(p, 1)));
        };
    }
    RenderResult draw(const Scene& scene, std::vector<Reformation> pictures, int threads = 0,
                      MemoryBudget* budget = nullptr) {
        layOutPictures(pictures);
        RenderOptions options;
        options.threads = threads;
        return renderReformed(scene, pictures, *reader, budget ? *budget : ram, options, share);
    }
    Formula ofPatientMm;
    VolumeInfo info;
    tessera::ScratchFolder folder;
    MemoryBudget ram{"RAM", "--ram", std::size_t{1} << 28};
    std::optional<StoreReader> reader;
    ReformedShare share;
};

Scene greys() {
    Scene scene;
    scene.volumes.push_back({{}, std::string("auto")});
    scene.mode = Mode::slice;
    scene.window = kWindow;
    return scene;
}

/// The value of a pixel by its grey.
double valueOf(const glm::vec4& pixel) {
    return kWindow.low() + kWindow.width * srgbFromLinear(static_cast<double>(pixel.g));
}

/// Even, anisotropic, mirrored and tilted, sheared as a gantry is.
std::vector<glm::dmat3> lattices() {
    const glm::dmat3 turned(
        glm::normalize(glm::dvec3(0.8, 0.5, 0.2)),
        glm::normalize(glm::cross(glm::dvec3(0.8, 0.5, 0.2), glm::dvec3(0, 1, 1))),
        glm::normalize(glm::cross(glm::dvec3(0.8, 0.5, 0.2),
                                  glm::cross(glm::dvec3(0.8, 0.5, 0.2), glm::dvec3(0, 1, 1)))));
    return {glm::dmat3(1), glm::dmat3(glm::dvec3(0.8, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1.6)),
            glm::dmat3(-0.9 * turned[0], turned[1], 1.3 * turned[2]),
            glm::dmat3(glm::dvec3(1, 0, 0), glm::dvec3(0, 0.95, 0), glm::dvec3(0, 0.3, 1.1))};
}
glm::ivec3 extentOf(const glm::dmat3& voxel) { // around 70 mm each way
    return glm::ivec3(glm::ceil(
        glm::dvec3(70 / glm::length(voxel[0]), 70 / glm::length(voxel[1]), 70 / glm::length(voxel[2]))));
}
double longestVoxel(const glm::dmat3& voxel) {
    return std::max({glm::length(voxel[0]), glm::length(voxel[1]), glm::length(voxel[2])});
}

/// Distances from the middle, of places where a row's values pass the radius: left, right, by interpolation.
std::pair<double, double> edgesOf(const Image& image, int y, int columns, double mmPerPixel, double radius) {
    std::pair<double, double> edges{1e9, 1e9};
    for (int x = 1; x < columns; ++x) {
        const double before = valueOf(image.at(x - 1, y)), here = valueOf(image.at(x, y));
        if ((before - radius) * (here - radius) > 0)
            continue;
        const double at = (x - 0.5 + (radius - before) / (here - before)) - 0.5 * columns;
        (at < 0 ? edges.first : edges.second) = std::abs(at) * mmPerPixel;
    }
    return edges;
}

/// A tube along a line: its value is the distance from that line.
struct TubeCase {
    const char* name;
    Formula distance;
    double lengthMm;
    std::function<glm::dvec3(double)> line;
    double voxels; // by which the edges may be off
};
std::vector<TubeCase> tubes() {
    constexpr double kBend = 20;
    const double rise = 5, radius = 18, speed = std::hypot(radius, rise);
    const auto helix = [=](double a) {
        return glm::dvec3(radius * std::cos(a), radius * std::sin(a), rise * (a - kPi));
    };
    return {
        {"straight",
         [](const glm::dvec3& p) {
             return glm::length(glm::cross(p, {0.6, 0, 0.8}));
         },
         50, [](double mm) { return (mm - 25) * glm::dvec3(0.6, 0, 0.8); }, 0.3},
        {"torus", [](const glm::dvec3& p) { return std::hypot(std::hypot(p.x, p.y) - kBend, p.z); },
         1.5 * kPi * kBend,
         [](double mm) { return glm::dvec3(kBend * std::cos(mm / kBend), kBend * std::sin(mm / kBend), 0); },
         0.5},
        {"helix",
         [=](const glm::dvec3& p) { // the nearest of its places
             double best = 1e9, at = 0;
             for (double a = -0.6; a < 2 * kPi + 0.6; a += 0.1)
                 if (const double d = glm::distance(p, helix(a)); d < best)
                     best = d, at = a;
             for (double step = 0.05; step > 1e-5; step /= 2)
                 for (const double a : {at - step, at + step})
                     if (const double d = glm::distance(p, helix(a)); d < best)
                         best = d, at = a;
             return best;
         },
         2 * kPi * speed, [=](double mm) { return helix(mm / speed); }, 0.5}};
}

TEST(ReformedPicture, TubesAreStraightBarsOfTheirWidth) {
    constexpr double kTube = 6, kPixel = 0.5;
    for (const TubeCase& tube : tubes())
        for (const glm::dmat3& voxel : lattices()) {
            Field field(tube.distance, voxel, extentOf(voxel));
            const FlightCurve line = curveOf(tube.lengthMm, tube.line);
            std::vector<Reformation> pictures;
            for (const double degrees : {0.0, 50.0, 90.0, 200.0})
                pictures.push_back(straightened(line, degrees, {24, kPixel, 1}));
            EXPECT_NEAR(pictures[0].size().y * kPixel, tube.lengthMm, 0.6);
            const Image image = field.draw(greys(), pictures).image;
            ASSERT_EQ(image.size.x, 4 * 48 + 3 * kReformedGap);
            EXPECT_EQ(field.share.folded, 0U);
            EXPECT_EQ(field.share.outside, 0U) << tube.name;
            double worst = 0;
            for (std::size_t n = 0; n < pictures.size(); ++n) {
                Image part({48, image.size.y});
                for (int y = 0; y < image.size.y; ++y)
                    for (int x = 0; x < 48; ++x)
                        part.pixels[static_cast<std::size_t>(y * 48 + x)] =
                            image.at(static_cast<int>(n) * (48 + kReformedGap) + x, y);
                for (int y = 4; y < image.size.y - 4; ++y) {
                    const auto [left, right] = edgesOf(part, y, 48, kPixel, kTube);
                    worst = std::max({worst, std::abs(left - kTube), std::abs(right - kTube)});
                }
            }
            EXPECT_LT(worst, tube.voxels * longestVoxel(voxel)) << tube.name;
        }
}

/// The same formula, written out once more.
glm::dvec4 expected(const Field& field, const Scene& scene, const Reformation& picture, int x, int y) {
    glm::dvec4 sum(0);
    const int side = picture.samples;
    for (int j = 0; j < side; ++j)
        for (int i = 0; i < side; ++i) {
            const ReformedRow& row = picture.rows[static_cast<std::size_t>(y * side + j)];
            const double mm = (x + (i + 0.5) / side) * picture.mmPerPixel;
            if (mm - row.lineMm >= row.highMm || mm - row.lineMm <= row.lowMm)
                continue;
            const glm::dvec3 middle = row.at + (mm - row.lineMm) * row.across;
            const glm::dmat4 inverse = glm::inverse(field.info.patientFromVoxel);
            const glm::dvec3 through(inverse * glm::dvec4(scene.slice.thicknessMm * row.towards, 0));
            const int layers =
                scene.slice.thicknessMm > 0 ? static_cast<int>(std::ceil(2 * glm::length(through))) : 1;
            double least = 1e300, most = -1e300, total = 0;
            int met = 0;
            for (int n = 0; n < layers; ++n) {
                const glm::dvec3 p =
                    glm::dvec3(inverse * glm::dvec4(middle, 1)) + ((n + 0.5) / layers - 0.5) * through;
                if (p.x < 0 || p.y < 0 || p.z < 0 || p.x > field.info.extentVoxels.x ||
                    p.y > field.info.extentVoxels.y || p.z > field.info.extentVoxels.z)
                    continue;
                const Formula stored = [&](const glm::dvec3& at) {
                    return static_cast<double>(static_cast<float>(field.stored()(at)));
                };
                const double value = trilinearOf(field.info, stored, p);
                least = std::min(least, value), most = std::max(most, value), total += value, ++met;
            }
            if (met == 0)
                continue;
            const double value = scene.slice.reduction == Reduction::maximum   ? most
                                 : scene.slice.reduction == Reduction::minimum ? least
                                                                               : total / met;
            const double part = std::min(1.0, std::max(0.0, (value - kWindow.low()) / kWindow.width));
            sum += glm::dvec4(glm::dvec3(linearFromSrgb(part)), 1);
        }
    return sum / static_cast<double>(side * side);
}

TEST(ReformedPicture, IsTheFormulaInDoublePrecision) {
    const Formula wavy = [](const glm::dvec3& p) {
        return 20 + 9 * std::sin(p.x / 3) + 7 * std::cos(p.y / 4 + p.z / 5);
    };
    const FlightCurve line = curveOf(
        100, [](double mm) { return glm::dvec3(22 * std::cos(mm / 22), 22 * std::sin(mm / 22), mm / 20); });
    std::size_t outside = 0, folded = 0;
    for (const glm::dmat3& voxel : lattices()) {
        Field field(wavy, voxel, extentOf(voxel));
        for (const auto& [thickness, reduction, samples] : {std::tuple{0.0, Reduction::average, 1},
                                                            {0.0, Reduction::average, 2},
                                                            {5.0, Reduction::average, 1},
                                                            {3.0, Reduction::maximum, 1},
                                                            {8.0, Reduction::minimum, 2}}) {
            Scene scene = greys();
            scene.slice.thicknessMm = thickness;
            scene.slice.reduction = reduction;
            const ReformedPixels pixels{60, 1.7, samples};
            for (const Reformation& picture : {straightened(line, 0, pixels), straightened(line, 35, pixels),
                                               stretched(line, {1, 0.4, -0.3}, {0, 0, 1}, pixels).picture,
                                               crossSection(line, 33, 10, pixels)}) {
                const Image image = field.draw(scene, {picture}).image;
                outside += field.share.outside, folded += field.share.folded;
                ASSERT_EQ(image.size, picture.size());
                double worst = 0;
                for (int y = 0; y < image.size.y; y += 3)
                    for (int x = 0; x < image.size.x; ++x) {
                        const glm::dvec4 e = expected(field, scene, picture, x, y), pixel(image.at(x, y));
                        bool hatched = e.a == 0 && pixel.a == 1; // on a diagonal, where rows fold
                        if (hatched)
                            hatched = (x + y) % 8 == 0;
                        if (!hatched)
                            worst = std::max(worst, glm::length(e - pixel));
                    }
                EXPECT_LT(worst, 2e-6);
            }
        }
    }
    EXPECT_GT(outside, 100U);
    EXPECT_GT(folded, 100U);
}

TEST(ReformedPicture, OfAStraightLineIsASlice) {
    const Formula wavy = [](const glm::dvec3& p) { return 20 + 9 * std::sin(p.x / 3 + p.y / 4 + p.z / 5); };
    for (const glm::dmat3& voxel : lattices()) {
        Field field(wavy, voxel, extentOf(voxel));
        const glm::dvec3 along(0.6, 0, 0.8);
        const FlightCurve line = curveOf(50, [&](double mm) { return (mm - 25) * along; });
        for (const double degrees : {0.0, 70.0}) {
            const Reformation picture = straightened(line, degrees, {30, 0.5, 1});
            const ReformedRow& row = picture.rows.front();
            Scene scene = greys();
            scene.quality.pixels.samples = 1;
            scene.quality.fetch = Fetch::exact;
            scene.imageSize = picture.size();
            Camera camera;
            camera.projection = Projection::parallel;
            camera.focalPoint = row.at + (0.25 * picture.size().y - 0.25) * along;
            camera.position = camera.focalPoint + 100.0 * row.towards;
            camera.viewUp = -along;
            camera.parallelScale = 0.25 * picture.size().y;
            scene.camera = camera;
            scene.slice = {Orientation::oblique, {}, camera.focalPoint, row.towards};
            RenderOptions options;
            options.engine = EngineKind::native;
            MemoryBudget gpu("GPU memory", "--gpu-memory", std::size_t{1} << 28);
            const auto expectSlice = [&](const Reformation& of) {
                const Image slice = renderScene(scene, *field.reader, field.ram, gpu, options).image;
                const Image image = field.draw(scene, {of}).image;
                ASSERT_EQ(slice.size, image.size);
                for (std::size_t n = 0; n < image.pixels.size(); ++n)
                    ASSERT_LT(glm::distance(image.pixels[n], slice.pixels[n]), 2e-5F) << n;
            };
            expectSlice(picture);
            // Across the line, as one sees it who looks back along it.
            const Reformation section = crossSection(line, 21, degrees, {30, 0.5, 1});
            scene.imageSize = section.size();
            camera.focalPoint = line.at(21).at;
            camera.position = camera.focalPoint + 100.0 * along;
            camera.viewUp = row.towards;
            camera.parallelScale = 0.25 * section.size().y;
            scene.camera = camera;
            scene.slice = {Orientation::oblique, {}, camera.focalPoint, along};
            expectSlice(section);
        }
    }
}

TEST(ReformedPicture, ThreadsAndMemoryChangeNothing) {
    const Formula wavy = [](const glm::dvec3& p) { return 20 + 9 * std::sin(p.x / 3 + p.y / 4 + p.z / 5); };
    Field field(wavy, glm::dmat3(0.4), {170, 160, 150});
    const FlightCurve line =
        curveOf(50, [](double mm) { return glm::dvec3(0, 3 * std::sin(mm / 6), mm - 25); });
    const std::vector<Reformation> pictures = {
        straightened(line, 0, {40, 0.3, 1}), straightened(line, 90, {40, 0.3, 1}),
        crossSection(line, 10, 0, {40, 0.3, 1}), crossSection(line, 30, 0, {40, 0.3, 1})};
    const Image ample = field.draw(greys(), pictures).image;
    const std::size_t floor = latticeCacheFloorBytes(field.info, 2) + (std::size_t{2} << 20);
    MemoryBudget scarce("RAM", "--ram", floor);
    const Image tight = field.draw(greys(), pictures, 2, &scarce).image;
    EXPECT_EQ(ample.pixels, tight.pixels);
    EXPECT_LE(scarce.peakBytes(), floor);
    EXPECT_EQ(ample.pixels, field.draw(greys(), pictures, 1).image.pixels);
    MemoryBudget none("RAM", "--ram", std::size_t{1} << 20);
    try {
        (void)field.draw(greys(), pictures, 2, &none);
        ADD_FAILURE() << "drawn in a megabyte";
    } catch (const InputError& e) {
        EXPECT_THAT(e.what(), ::testing::HasSubstr("--ram"));
    }
}

TEST(ReformedPicture, TellsWhatItIsOf) {
    Field field([](const glm::dvec3& p) { return p.x; }, glm::dmat3(1), {64, 40, 40});
    const FlightCurve line = curveOf(20, [](double mm) { return glm::dvec3(0, 0, mm - 10); });
    const RenderResult result = field.draw(greys(), {straightened(line, 0, {10, 0.5, 3})});
    EXPECT_EQ(result.lowest, -31.5);
    EXPECT_EQ(result.highest, 31.5);
    EXPECT_EQ(result.window, kWindow);
    EXPECT_EQ(result.pixels.asked, 9);
    EXPECT_EQ(result.pixels.taken, 9);
    EXPECT_EQ(result.pixels.most, 9);
    EXPECT_TRUE(result.levelsOnPurpose);
    EXPECT_GE(result.secondsDrawing, 0);
    EXPECT_EQ(field.share.pixels, result.image.pixels.size());
}

TEST(ReformedPicture, HasTheScenesCutsAndFunction) {
    Field field([](const glm::dvec3& p) { return p.x; }, glm::dmat3(1), {64, 64, 64});
    const FlightCurve line = curveOf(40, [](double mm) { return glm::dvec3(0, 0, mm - 20); });
    Scene scene = greys();
    scene.cuts.boxes.push_back({{-10, -50, -50}, {5, 50, 50}, CropBox::Space::patient, Keep::inside});
    scene.valueColour = ValueColour::transferFunction;
    scene.volumes.front().transferFunction =
        TransferFunction::fromOpacity({{-30, 0}, {30, 1}}, {{-1, {0, 0, 1}}, {1, {1, 0, 0}}}, 1);
    const Reformation picture = straightened(line, 0, {40, 0.5, 1});
    const Image image = field.draw(scene, {picture}).image;
    for (int x = 0; x < image.size.x; ++x) {
        const double across = picture.rows[20].place((x + 0.5) * 0.5).x;
        const glm::vec4 pixel = image.at(x, 20);
        EXPECT_EQ(pixel.a, across > -10 && across < 5 ? 1.0F : 0.0F) << across;
        if (pixel.a > 0 && std::abs(across) > 2) {
            EXPECT_EQ(pixel.r > pixel.b, across > 0);
        }
    }
}

} // namespace
} // namespace tessera::test
