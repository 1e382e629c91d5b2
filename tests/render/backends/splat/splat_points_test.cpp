// tests/render/backends/splat/splat_points_test.cpp: points of no lattice among splats: their opacity and
// place, before and behind tissue; bits over threads and budgets; what is refused. Slices that change their
// axis as the camera turns.
#include "render/geometry/point_shape.h"
#include "render/picture/render_scene.h"
#include "tests/support/mesh_shapes.h"
#include "tests/support/refusals.h"
#include "tests/support/splat_scene.h"
#include "tests/support/voxel_checks.h"

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>

namespace tessera::test {
namespace {

MemoryBudget& pointRam() {
    static MemoryBudget ram("RAM", "--ram", std::size_t{1} << 30);
    return ram;
}

SceneMesh pointsAt(const std::vector<glm::vec3>& points, double radiusMm, const glm::dvec3& colour,
                   double opacity = 1) {
    SceneMesh mesh;
    mesh.path = "points.ply";
    mesh.colour = colour;
    mesh.opacity = opacity;
    mesh.shape = std::make_shared<const PointShape>(points, radiusMm, pointRam());
    return mesh;
}

/// Looks along y at a volume of 64^3 voxels of 1 mm; a pixel is half a millimetre.
struct Fog : SplatScene {
    Fog(double angle, double perMm) : SplatScene({64, 64, 64}, [](const glm::dvec3&) { return 1.0; }) {
        show({{0, perMm}, {2, perMm}}, {{0, {1, 0, 0}}, {2, {1, 0, 0}}});
        Camera camera;
        camera.projection = Projection::parallel;
        camera.focalPoint = {32, 32, 32};
        camera.position = camera.focalPoint - 300.0 * glm::dvec3(std::sin(angle), std::cos(angle), 0);
        camera.viewUp = {0, 0, 1};
        camera.parallelScale = 20;
        scene.camera = camera;
    }
};

glm::vec4 middleOf(const Image& image) {
    return image.pixels[static_cast<std::size_t>(40 * image.size.x + 48)];
}

// Alone: the mesh's opacity in the middle, a Gaussian of half the radius around it.
TEST(SplatPoints, HaveTheirOpacityAndRadius) {
    for (const double opacity : {0.3, 1.0})
        for (const float y : {32.0f, -50.0f, 150.0f}) { // before and behind the volume, too
            Fog s(0, 0);
            s.scene.meshes = {pointsAt({{32.25f, y, 31.75f}}, 6, {0.2, 0.4, 0.8}, opacity)};
            const Image image = s.draw();
            const glm::vec4 middle = middleOf(image);
            EXPECT_NEAR(middle.a, opacity, 0.03) << y;
            EXPECT_NEAR(middle.b, 0.8f * middle.a, 1e-4);
            EXPECT_NEAR(middle.r, 0.2f * middle.a, 1e-4);
            const auto depth = [&](int right) {
                return -std::log1p(-double{image.pixels[static_cast<std::size_t>(40 * 96 + 48 + right)].a});
            };
            if (opacity < 1) { // at a radius, twelve pixels; of a filter of half a pixel
                EXPECT_NEAR(depth(12) / depth(0), std::exp(-2), 0.02);
            }
            EXPECT_EQ(depth(30), 0);
        }
}

// In fog: its share is what the fog before it leaves, whichever way slices go.
TEST(SplatPoints, LieAmongSlices) {
    constexpr double kPerMm = 0.03;
    for (const bool behind : {false, true})
        for (const double y : {4.5, 20.5, 45.5, 60.5}) {
            Fog s(behind ? std::acos(-1.0) : 0, kPerMm);
            s.scene.meshes = {pointsAt({{32, static_cast<float>(y), 32}}, 8, {0, 0, 1})};
            const double before = std::exp(-kPerMm * (behind ? 64 - y : y));
            EXPECT_NEAR(middleOf(s.draw()).b, before, 0.02) << behind << " " << y;
            s.scene.cuts.boxes.emplace_back(); // a cut takes the point, or leaves it
            CropBox& box = s.scene.cuts.boxes.back();
            box.space = CropBox::Space::voxels;
            box.low = {0, 0, 0}, box.high = {64, 30, 64};
            EXPECT_EQ(middleOf(s.draw()).b > 0, y < 30);
            s.scene.meshes[0].clipped = false;
            EXPECT_GT(middleOf(s.draw()).b, 0.05f);
        }
}

TEST(SplatPoints, ThreadsAndBudgetsChangeNoBit) {
    SplatScene s(storePath("torso"), {150, 110});
    std::mt19937 random(5);
    std::uniform_real_distribution<float> unit(0, 1);
    const glm::dmat4& place = s.store->info().patientFromVoxel;
    const glm::dvec3 extent(s.store->info().extentVoxels);
    std::vector<glm::vec3> points[2];
    for (int n = 0; n < 20000; ++n)
        points[n % 2].emplace_back(
            place *
            glm::dvec4(extent * (1.4 * glm::dvec3(unit(random), unit(random), unit(random)) - 0.2), 1));
    s.scene.meshes = {pointsAt(points[0], 3, {1, 0, 0}, 0.7), pointsAt(points[1], 1.5, {0, 1, 0})};
    for (const int camera : {0, 1, 2}) {
        s.scene.camera = cameraNumber(camera, s.store->info(), s.scene.imageSize);
        Planner p = s.plan();
        const Image one = s.draw(p, {}, 1);
        const std::size_t drawn = s.report.counts.drawn;
        EXPECT_TRUE(bitEqual(s.draw(p, {}, 3), one)) << camera;
        MemoryBudget small("GPU memory", "--gpu-memory", std::size_t{5} << 20);
        EXPECT_TRUE(bitEqual(s.draw(p, {}, 2, &small), one)) << camera;
        EXPECT_LE(small.peakBytes(), small.limitBytes());
        s.scene.meshes[0].show = s.scene.meshes[1].show = false;
        Planner without = s.plan();
        EXPECT_FALSE(bitEqual(s.draw(without), one));
        EXPECT_LT(s.report.counts.drawn, drawn);
        s.scene.meshes[0].show = s.scene.meshes[1].show = true;
    }
}

/// Rays meet points as balls; splats draw no triangles.
TEST(SplatPoints, AreBallsForRays) {
    Fog s(0, 0);
    s.scene.meshes = {pointsAt({{32, 32, 32}}, 6, {0, 0, 1})};
    RenderOptions options;
    options.engine = EngineKind::native;
    const Image balls = renderScene(s.scene, *s.store, s.budgets.ram, s.budgets.gpu, options).image;
    EXPECT_EQ(middleOf(balls), glm::vec4(0, 0, 1, 1));
    const auto shown = static_cast<double>(
        std::count_if(balls.pixels.begin(), balls.pixels.end(), [](const auto& p) { return p.a > 0; }));
    EXPECT_NEAR(shown / (std::acos(-1.0) * 12 * 12), 1, 0.03);
    options.engine = EngineKind::splat;
    EXPECT_GT(middleOf(renderScene(s.scene, *s.store, s.budgets.ram, s.budgets.gpu, options).image).b, 0.9f);
    s.scene.meshes.push_back(sceneMesh(quadMesh({0, 0, 0}, {9, 0, 0}, {0, 9, 0}), pointRam()));
    EXPECT_THAT(refusalOf([&] { renderScene(s.scene, *s.store, s.budgets.ram, s.budgets.gpu, options); }),
                testing::HasSubstr("splat: it draws no meshes but points of files"));
}

// From one axis of slices to another, and where all three meet: pictures change no more than a turn explains.
TEST(SplatOrders, TurningCamerasShowNoJump) {
    SplatScene s(storePath("torso"), {96, 80});
    s.scene.shading.on = false;
    const VolumeInfo& info = s.store->info();
    const glm::dvec3 middle(info.patientFromVoxel * glm::dvec4(0.5 * glm::dvec3(info.extentVoxels), 1));
    const auto from = [&](const glm::dvec3& towards, double fade) {
        Camera camera = std::get<Camera>(s.scene.camera);
        camera.focalPoint = middle;
        camera.position = middle + 700.0 * glm::normalize(towards);
        camera.viewUp = {0, 0, 1};
        s.scene.camera = camera;
        SplatSettings settings;
        settings.fade = fade;
        return s.draw(settings);
    };
    for (const double up : {0.0, 0.7, 1.0}) { // the last is the diagonal of three axes
        const auto jump = [&](double fade) {
            return rmsOf(from({1, -1.0001, up}, fade), from({1.0001, -1, up}, fade));
        };
        const double popping = jump(0), faded = jump(3);
        EXPECT_GT(popping, 0.005) << up;
        EXPECT_LT(faded, 0.05 * popping) << up;
        // At an end of the fade, too.
        const double at = std::tan(std::acos(-1.0) / 4 + std::acos(-1.0) / 120);
        EXPECT_LT(rmsOf(from({at * 1.0001, -1, 0}, 3), from({at / 1.0001, -1, 0}, 3)), 0.05 * popping);
    }
}

// Shares add up to one, and the best order has the largest.
TEST(SplatOrders, SharesAreOfAWhole) {
    const VolumeInfo info = StoreReader(storePath("torso"), pointRam()).info();
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    std::size_t mixed = 0;
    for (int n = 0; n < 2000; ++n) {
        Camera camera;
        camera.position = glm::normalize(glm::dvec3(normal(random), normal(random), normal(random))) * 500.0;
        camera.viewUp = {0.3, 0.2, 1};
        const SplatView view = splatView(camera, info, {64, 64});
        const auto orders = SliceOrder::of(view, info, 3);
        double sum = 0;
        for (const auto& [order, share] : orders) {
            EXPECT_GT(share, 0);
            EXPECT_LE(share, orders.front().second);
            sum += share;
        }
        EXPECT_NEAR(sum, 1, 1e-12);
        EXPECT_EQ(SliceOrder::of(view, info, 0).size(), 1u);
        EXPECT_EQ(SliceOrder::of(view, info, 0).front().first.axis, orders.front().first.axis);
        mixed += orders.size() > 1 ? 1 : 0;
    }
    EXPECT_GT(mixed, 40u);
    EXPECT_LT(mixed, 250u);
}

} // namespace
} // namespace tessera::test
