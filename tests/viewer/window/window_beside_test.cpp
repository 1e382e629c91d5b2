// tests/viewer/window/window_beside_test.cpp: another scan beside the open one: it is seen by the same
// camera, moved with it, and asked for when the desk's picture is.
#include "tests/support/desk.h"
#include "viewer/window/beside.h"

#include <gtest/gtest.h>
#include <thread>

namespace tessera {
namespace {

using test::Desk;
using test::PretendedViewing;

/// The pretended scan, elsewhere in its patient's space.
VolumeSeen movedScan(const glm::dvec3& by) {
    VolumeSeen seen = *test::pretendedVolume({400, 300});
    seen.info.patientFromVoxel[3] += glm::dvec4(by, 0);
    seen.scene.volumes.front().path = "/scans/later.zarr";
    return seen;
}

constexpr glm::dvec3 kBy{11, -7, 300};

// A scan that was only moved is seen as before: all places of the scene move with it.
TEST(WindowBeside, AMovedScanIsSeenAlike) {
    const VolumeSeen of = *test::pretendedVolume({400, 300}), other = movedScan(kBy);
    Scene scene = of.scene;
    scene.cuts.boxes = {{{-5, -5, -5}, {5, 6, 7}}, {{1, 1, 1}, {9, 9, 9}, CropBox::Space::voxels}};
    scene.cuts.planes = {{{1, 2, 3}, {0, 0, 1}}};
    scene.cuts.scissors = {{std::get<Camera>(scene.camera), 1.5, {{0, 0}, {1, 0}, {0, 1}}}};
    scene.meshes = {{"/scans/bone.ply"}};
    scene.shading.ambient = 0.31;
    const Scene beside = sceneBeside(scene, of.info, other);
    EXPECT_EQ(beside.volumes.front().path, "/scans/later.zarr");
    EXPECT_EQ(beside.volumes.size(), 1u);
    const auto &camera = std::get<Camera>(scene.camera), &moved = std::get<Camera>(beside.camera);
    EXPECT_EQ(moved.position, camera.position + kBy);
    EXPECT_EQ(moved.focalPoint, camera.focalPoint + kBy);
    EXPECT_EQ(moved.viewUp, camera.viewUp);
    ASSERT_EQ(beside.cuts.boxes.size(), 1u) << "voxels are of one volume";
    EXPECT_EQ(beside.cuts.boxes[0].low, glm::dvec3(-5) + kBy);
    EXPECT_EQ(beside.cuts.boxes[0].high, glm::dvec3(5, 6, 7) + kBy);
    EXPECT_EQ(beside.cuts.planes[0].point, glm::dvec3(1, 2, 3) + kBy);
    EXPECT_EQ(beside.cuts.scissors[0].camera.position, camera.position + kBy);
    EXPECT_TRUE(beside.meshes.empty());
    EXPECT_EQ(beside.shading.ambient, 0.31);
}

TEST(WindowBeside, PlanesGoToTheSamePlace) {
    const VolumeSeen of = *test::pretendedVolume({400, 300}), other = movedScan(kBy);
    for (const Orientation orientation : {Orientation::axial, Orientation::coronal, Orientation::sagittal}) {
        const int axis = orientation == Orientation::axial ? 2 : orientation == Orientation::coronal ? 1 : 0;
        Scene scene = of.scene;
        scene.mode = Mode::slice;
        scene.slice.orientation = orientation;
        EXPECT_EQ(sceneBeside(scene, of.info, other).slice.positionMm, kBy[axis]) << "of the middle";
        scene.slice.positionMm = 12;
        EXPECT_EQ(sceneBeside(scene, of.info, other).slice.positionMm, 12 + kBy[axis]);
    }
    Scene scene = of.scene;
    scene.slice.orientation = Orientation::oblique;
    scene.slice.point = {3, 4, 5};
    EXPECT_EQ(sceneBeside(scene, of.info, other).slice.point, glm::dvec3(3, 4, 5) + kBy);
}

// Places of one frame of reference are the same places, wherever the scans' middles are.
TEST(WindowBeside, OneFrameOfReferenceIsNotMoved) {
    VolumeSeen of = *test::pretendedVolume({400, 300}), other = movedScan(kBy);
    EXPECT_EQ(shiftBetween(of.info, other.info), kBy) << "unknown frames are not the same";
    of.info.frameOfReference = "1.2.3";
    other.info.frameOfReference = "1.2.4";
    EXPECT_EQ(shiftBetween(of.info, other.info), kBy);
    EXPECT_EQ(shiftBetween(other.info, of.info), -kBy);
    other.info.frameOfReference = "1.2.3";
    EXPECT_EQ(shiftBetween(of.info, other.info), glm::dvec3(0));
}

TEST(WindowBeside, AnotherUnitKeepsItsFunction) {
    const VolumeSeen of = *test::pretendedVolume({400, 300});
    VolumeSeen other = movedScan(kBy);
    const TransferFunction own = TransferFunction::fromOpacity({{0, 0}, {9, 1}}, {{0, {1, 0, 0}}}, 1);
    other.scene.volumes.front().transferFunction = own;
    EXPECT_NE(
        std::get<TransferFunction>(sceneBeside(of.scene, of.info, other).volumes.front().transferFunction)
            .kinks(),
        own.kinks());
    other.info.unit = "SUV";
    EXPECT_EQ(
        std::get<TransferFunction>(sceneBeside(of.scene, of.info, other).volumes.front().transferFunction)
            .kinks(),
        own.kinks());
}

// Whatever is asked for at the desk is asked for beside it once, first as moving, then at rest.
TEST(WindowBeside, AsksWhenTheDeskAsks) {
    Desk d;
    auto owned = std::make_unique<PretendedViewing>();
    PretendedViewing& viewing = *owned;
    Beside beside(std::move(owned), "/scans/later.zarr");
    const glm::ivec2 size(400, 300);
    beside.update(d.desk, size);
    ASSERT_EQ(viewing.said.size(), 1u);
    EXPECT_EQ(viewing.said[0].rfind("open later.zarr at 400 x 300", 0), 0u) << viewing.said[0];
    EXPECT_EQ(viewing.shows, 0u);
    EXPECT_FALSE(beside.atRest());
    viewing.opened(size);
    beside.update(d.desk, size);
    EXPECT_EQ(viewing.shows, 1u);
    beside.update(d.desk, size);
    EXPECT_EQ(viewing.shows, 1u) << "nothing is new";
    Camera camera = d.desk.camera();
    camera.position.x += 20;
    d.desk.setCamera(camera, true);
    beside.update(d.desk, size);
    EXPECT_EQ(viewing.shows, 2u);
    EXPECT_TRUE(viewing.moving);
    EXPECT_EQ(std::get<Camera>(viewing.asked.camera).position, camera.position);
    std::this_thread::sleep_for(std::chrono::milliseconds(250));
    d.desk.settle();
    beside.update(d.desk, size);
    EXPECT_FALSE(viewing.moving);
    const std::uint64_t before = viewing.shows;
    beside.update(d.desk, {300, 300});
    EXPECT_EQ(viewing.shows, before + 1) << "another size";
    EXPECT_EQ(viewing.asked.imageSize, glm::ivec2(300, 300));
}

// One that cannot be opened is told of, and waited for no longer.
TEST(WindowBeside, WhatCannotBeOpenedIsTold) {
    Desk d;
    auto owned = std::make_unique<PretendedViewing>();
    owned->now.kind = ViewingState::Kind::failed;
    owned->now.what = "/scans/later.zarr: expected a volume, found nothing";
    Beside beside(std::move(owned), "/scans/later.zarr");
    beside.update(d.desk, {400, 300});
    EXPECT_TRUE(beside.atRest());
    EXPECT_NE(beside.about(d.desk).find("expected a volume"), std::string::npos);
}

} // namespace
} // namespace tessera
