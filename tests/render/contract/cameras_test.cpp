// Cameras in awkward places: exactly on faces, edges and corners of the volume and of bricks, a million
// millimetres away, or looking elsewhere. Also axis-parallel rays, extreme angles, and a volume one voxel
// thin.
#include "tests/support/scene_fixture.h"

#include <cmath>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace tessera::test;

constexpr glm::ivec2 kSize(17, 17); // odd: the middle ray runs exactly along the view direction

/// GPU ray caster against float mirror on the GPU's rays, and everything finite and within [0, opaque].
void expectSound(const std::string& store, const Camera& camera, const std::string& what) {
    SCOPED_TRACE(what);
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    const VolumeInfo info = StoreReader(storePath(store), ram).info();
    Scene scene = sceneOn(info, "auto", 0, kSize);
    scene.camera = camera;
    Prepared prepared(store, scene);
    Planner& p = prepared.p;
    const GpuPicture gpu = marchOn(prepared, kFeatureSkipping | kFeatureShading);
    const auto rays = gpuRays(p.view.frame, prepared.budgets.gpu);
    Work work;
    const auto mirror = mirrorRays<float>(
        mirrorInput(p, true), rays.size(), [&](std::size_t i) { return rays[i]; }, 0, work);
    // Rays in double, from the camera itself: what float makes of them stays within the picture's sampling
    // error.
    Work doubleWork;
    const auto exact =
        mirrorRays<double>(mirrorInput(p, false), rays.size(), frameRays(p.view.frame), 0, doubleWork);
    std::size_t far = 0;
    for (std::size_t i = 0; i < rays.size(); ++i)
        for (int c = 0; c < 4; ++c) {
            ASSERT_TRUE(std::isfinite(gpu.image.pixels[i][c])) << i;
            ASSERT_NEAR(gpu.image.pixels[i][c], mirror[i][c], 1e-4) << i;
            if (std::abs(static_cast<double>(mirror[i][c]) - exact[i][c]) > 0.02)
                ++far;
        }
    // Rays that graze a face may fall on either side of it; no more than one row of pixels can.
    EXPECT_LE(far, 4u * kSize.x);
}

TEST(Cameras, OnFacesEdgesAndCorners) {
    const GlContext context({"software"});
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    const VolumeInfo info = StoreReader(storePath("torso"), ram).info();
    const auto patient = [&](const glm::dvec3& voxel) {
        return glm::dvec3(info.patientFromVoxel * glm::dvec4(voxel, 1));
    };
    const glm::dvec3 n(info.extentVoxels);
    const std::vector<std::pair<const char*, glm::dvec3>> places = {
        {"face of the volume", {n.x / 2, 0, n.z / 2}}, {"edge of the volume", {0, 0, n.z / 2}},
        {"corner of the volume", {0, 0, 0}},           {"face of a brick", {64, 50.3, 70.1}},
        {"edge of a brick", {64, 64, 70.1}},           {"corner of a brick", {64, 64, 64}},
        {"centre of a voxel", {75.5, 55.5, 86.5}}};
    for (const auto& [what, voxel] : places)
        for (const glm::dvec3 direction :
             {glm::dvec3(0, 1, 0), glm::dvec3(1, 0, 0), glm::dvec3(-1, 1, 0), glm::dvec3(0.3, 0.5, -0.7)}) {
            Camera camera;
            camera.position = patient(voxel);
            camera.focalPoint = camera.position + direction;
            camera.viewAngle = 130;
            expectSound("torso", camera, what);
        }
}

TEST(Cameras, FarNarrowWideAndElsewhere) {
    const GlContext context({"software"});
    Camera camera;
    camera.position = {0, -1e6, 0};
    camera.focalPoint = {0, 0, 0};
    camera.viewAngle = 0.02;
    expectSound("torso", camera, "a kilometre away");
    camera.position = {0, -400, 0};
    camera.viewAngle = 170;
    expectSound("torso", camera, "170 degrees");
    camera.viewAngle = 1;
    expectSound("torso", camera, "1 degree");
    camera.projection = Projection::parallel;
    camera.parallelScale = 200;
    expectSound("torso", camera, "parallel along an axis");
    camera.projection = Projection::perspective;
    camera.viewAngle = 30;
    camera.focalPoint = {0, -800, 0};
    expectSound("torso", camera, "looking away");
}

TEST(Cameras, VolumeOneVoxelThin) {
    const GlContext context({"software"});
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    const VolumeInfo info = StoreReader(storePath("thin"), ram).info();
    for (const View view : {View::anterior, View::left, View::superior})
        for (const Projection projection : {Projection::perspective, Projection::parallel})
            expectSound("thin", fitCamera(info, view, projection, kSize), "thin");
}

} // namespace
} // namespace tessera
