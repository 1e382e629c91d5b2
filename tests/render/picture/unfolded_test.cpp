// tests/render/picture/unfolded_test.cpp: tubes whose unfolded pictures are known in closed form. These are
// shells of an even medium, whose opacity is the same in every direction from their middle, and a patch on
// the wall at a known place.
#include "bricking/import/importer.h"
#include "core/animation/flight.h"
#include "core/base/program_folders.h"
#include "render/picture/unfolded.h"
#include "tests/support/formula_source.h"
#include "tests/support/scene_fixture.h"

#include <cmath>
#include <numbers>

namespace tessera::test {
namespace {

constexpr double kPi = std::numbers::pi;

/// A float volume of 64^3 voxels, 1 mm, around 0.
struct Tube {
    explicit Tube(const Formula& ofPatientMm) {
        VolumeInfo info;
        info.extentVoxels = glm::ivec3(64);
        info.type = ValueType::f32;
        info.patientFromVoxel = glm::dmat4(1);
        info.patientFromVoxel[3] = glm::dvec4(-32, -32, -32, 1);
        FormulaSource source(info, [&](const glm::dvec3& p) { return ofPatientMm(p - 32.0); });
        importToStore(source, folder / "tube.zarr", budgets.ram, {});
        reader.emplace(folder / "tube.zarr", budgets.ram);
    }
    ScratchFolder folder;
    Budgets budgets;
    std::optional<StoreReader> reader;
};

Scene unlit(const TransferFunction& function, const glm::ivec2& size) {
    Scene scene;
    scene.volumes.push_back({{}, function});
    scene.shading.on = false;
    scene.imageSize = size;
    scene.quality.fetch = Fetch::exact;
    scene.quality.terminationTransmittance = 0;
    scene.quality.stepVoxels = 0.25;
    return scene;
}

RenderOptions with(EngineKind engine) {
    RenderOptions options;
    options.engine = engine;
    options.device.text = "software";
    return options;
}

/// Along z through a place, up towards +x.
std::vector<UnfoldedRow> straight(int rows, double from, double to, const glm::dvec2& at = {0, 0}) {
    std::vector<UnfoldedRow> all;
    for (int y = 0; y < rows; ++y)
        all.push_back({{at, from + (to - from) * (y + 0.5) / rows}, {0, 0, 1}, {1, 0, 0}});
    return all;
}

TEST(Unfolded, AShellIsEvenAllAround) {
    // value: distance from the axis; an even medium from 12 to 20 mm
    Tube tube([](const glm::dvec3& p) { return std::hypot(p.x, p.y); });
    const double extinction = 0.1;
    const TransferFunction shell = TransferFunction::fromExtinction(
        {{12, 0}, {12, extinction}, {20, extinction}, {20, 0}}, {{0, {0.2, 0.6, 1}}});
    const double expected = 1 - std::exp(-extinction * 8);
    const Scene scene = unlit(shell, {37, 5}); // no quarter begins at a pixel
    for (const EngineKind engine :
         {EngineKind::mirror, EngineKind::native, EngineKind::gpu, EngineKind::reference}) {
        const Image image = renderUnfolded(scene, straight(5, -20, 20), *tube.reader, tube.budgets.ram,
                                           tube.budgets.gpu, with(engine))
                                .image;
        ASSERT_EQ(image.size, glm::ivec2(37, 5));
        for (const glm::vec4& pixel : image.pixels) // steps end within a quarter voxel of the shell's faces
            EXPECT_NEAR(static_cast<double>(pixel.a), expected, 0.02) << name(engine);
    }
}

TEST(Unfolded, EnginesAgreeAndPassesChangeNothing) {
    Tube tube(
        [](const glm::dvec3& p) { return std::hypot(p.x - 3, p.y) + 2 * std::sin(p.z / 3) + 0.05 * p.y; });
    Scene scene = unlit(
        TransferFunction::fromOpacity({{10, 0}, {16, 0.4}}, {{10, {1, 0, 0}}, {18, {0, 1, 1}}}, 1), {40, 8});
    scene.shading.on = true;
    const auto draw = [&](EngineKind engine, std::size_t gpuBytes) {
        MemoryBudget gpu("GPU memory", "--gpu-memory", gpuBytes);
        return renderUnfolded(scene, straight(8, -25, 25), *tube.reader, tube.budgets.ram, gpu, with(engine))
            .image;
    };
    constexpr std::size_t kAmple = std::size_t{1} << 28;
    const Image mirror = draw(EngineKind::mirror, kAmple);
    EXPECT_TRUE(bitEqual(draw(EngineKind::native, kAmple), mirror));
    EXPECT_TRUE(bitEqual(draw(EngineKind::native, std::size_t{6} << 20), mirror)) << "in passes";
    const Image march = draw(EngineKind::gpu, kAmple);
    for (std::size_t n = 0; n < march.pixels.size(); ++n)
        EXPECT_LT(glm::distance(march.pixels[n], mirror.pixels[n]), 2e-5F) << n;
}

TEST(Unfolded, APatchIsWhereItShouldBe) {
    // seen from the axis: a patch of the wall from 100 to 160 degrees, z from -6 to 10
    const auto inPatch = [](const glm::dvec3& p) {
        const double angle =
            std::atan2(p.y, p.x) * 180 / kPi; // from +x towards +y: clockwise for a view along +z
        return angle > 100 && angle < 160 && p.z > -6 && p.z < 9.9;
    };
    Tube tube([&](const glm::dvec3& p) {
        return std::hypot(p.x, p.y) < 14 ? 0.0 : inPatch(p) ? -100.0 : 100.0;
    });
    constexpr int kColumns = 72, kRows = 20;
    const Scene scene = unlit(TransferFunction::fromOpacity({{-60, 1}, {-40, 0}, {40, 0}, {60, 1}},
                                                            {{-1, {0, 1, 0}}, {1, {1, 0, 0}}}, 1),
                              {kColumns, kRows});
    const Image image = renderUnfolded(scene, straight(kRows, -20, 20), *tube.reader, tube.budgets.ram,
                                       tube.budgets.gpu, with(EngineKind::native))
                            .image;
    int patch = 0;
    for (int y = 0; y < kRows; ++y)
        for (int x = 0; x < kColumns; ++x) {
            const double degrees = 360 * (x + 0.5) / kColumns, z = -20 + 40 * (y + 0.5) / kRows;
            const glm::vec4 pixel = image.at(x, y);
            EXPECT_GT(pixel.a, 0.99F) << x << " " << y;
            const auto within = [&](double by) {
                return degrees > 100 - by && degrees < 160 + by && z > -6 - by / 5 && z < 10 + by / 5;
            };
            patch += pixel.g > pixel.r;
            if (within(-6)) {
                EXPECT_GT(pixel.g, pixel.r) << degrees << " " << z;
            }
            if (!within(6)) {
                EXPECT_LT(pixel.g, pixel.r) << degrees << " " << z;
            }
        }
    EXPECT_NEAR(patch, 60.0 / 5 * 16 / 2, 14);
}

/// Round a bend: a flight along a circle, whose wall is a torus. Rays stand on the line.
TEST(Unfolded, ABendStaysEven) {
    constexpr double kBend = 20;
    Tube tube([](const glm::dvec3& p) { return std::hypot(std::hypot(p.x, p.y) - kBend, p.z); });
    const double extinction = 0.3;
    const Scene scene = unlit(
        TransferFunction::fromExtinction({{5, 0}, {5, extinction}, {8, extinction}, {8, 0}}, {}), {32, 12});
    CentreLine circle;
    constexpr int kPoints = 120;
    for (int i = 0; i < kPoints; ++i) {
        const double a = 1.5 * kPi * i / (kPoints - 1);
        circle.points.emplace_back(kBend * std::cos(a), kBend * std::sin(a), 0);
        circle.radiusMm.push_back(5);
    }
    circle.spacingMm = 1.5 * kPi * kBend / (kPoints - 1);
    Flight flight;
    flight.lookAheadMm = 0;
    const FlightCurve curve({circle}, flight);
    std::vector<UnfoldedRow> rows;
    for (int y = 0; y < 12; ++y) {
        const Pose pose = curve.at(curve.lengthMm() * (y + 0.5) / 12);
        rows.push_back({pose.at, pose.direction, pose.up});
        EXPECT_NEAR(glm::dot(unfoldedDirection(rows.back(), 5, 32), pose.direction), 0, 1e-12);
    }
    const Image image = renderUnfolded(scene, rows, *tube.reader, tube.budgets.ram, tube.budgets.gpu,
                                       with(EngineKind::native))
                            .image;
    int tested = 0;
    for (int y = 0; y < 12; ++y)
        for (int x = 0; x < 32; ++x) {
            const UnfoldedRow& row = rows[static_cast<std::size_t>(y)];
            if (glm::dot(unfoldedDirection(row, x + 0.5, 32), -glm::normalize(row.at)) > 0.85)
                continue; // meets the tube again, across the bend
            EXPECT_NEAR(static_cast<double>(image.at(x, y).a), 1 - std::exp(-extinction * 3), 0.06)
                << x << " " << y;
            ++tested;
        }
    EXPECT_GT(tested, 300);
}

TEST(Unfolded, ASliceHasNoEye) {
    Tube tube([](const glm::dvec3& p) { return p.x; });
    Scene scene = unlit(TransferFunction::fromOpacity({{0, 1}}, {}, 1), {4, 2});
    scene.mode = Mode::slice;
    EXPECT_THROW(renderUnfolded(scene, straight(2, 0, 1), *tube.reader, tube.budgets.ram, tube.budgets.gpu,
                                with(EngineKind::native)),
                 InputError);
}

} // namespace
} // namespace tessera::test
