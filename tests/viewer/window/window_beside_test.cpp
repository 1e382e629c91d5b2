// tests/viewer/window/window_beside_test.cpp: another scan beside the open one: it is seen by the same
// camera, moved with it, and asked for when the desk's picture is.
#include "tests/support/desk.h"
#include "tests/support/headless_window.h"
#include "viewer/annotations/shown_plane.h"
#include "viewer/session/view_geometry.h"
#include "viewer/window/beside.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <variant>

namespace tessera {
namespace {

using test::Desk;
using test::HeadlessWindow;
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

// Scans of which one has the middle of the other are linked by coordinates, and it is said that nothing
// vouches for them.
TEST(WindowBeside, PlacesAreLinkedByCoordinatesWhereScansMeet) {
    using Places = BesideLinks::Places;
    const VolumeSeen of = *test::pretendedVolume({400, 300});
    const glm::dvec3 size(40, 60, 120); // of the pretended scan, mm
    for (int axis = 0; axis < 3; ++axis)
        for (const bool meets : {true, false}) {
            glm::dvec3 by(3, -4, 5);
            by[axis] = (meets ? 0.49 : 0.51) * size[axis];
            const VolumeSeen other = movedScan(by);
            EXPECT_EQ(shiftBetween(of.info, other.info), meets ? glm::dvec3(0) : by) << axis;
            EXPECT_EQ(shiftBetween(of.info, other.info, {.places = Places::middles}), by);
            EXPECT_EQ(shiftBetween(of.info, other.info, {.places = Places::coordinates}), glm::dvec3(0));
        }
}

TEST(WindowBeside, TheWindowTellsHowPlacesAreLinked) {
    HeadlessWindow w({1200, 700}, {{330, 0}, {300, 300}, 1});
    w.viewing.opened({300, 300});
    PretendedViewing& other = w.addSecond({5, 0, 0});
    w.frame();
    w.frame();
    EXPECT_NE(w.second->beside.about(w.desk).find("by patient coordinates"), std::string::npos);
    EXPECT_TRUE(w.shows("coordinates,")) << "over the picture";
    w.clickOn("middle on middle");
    w.frame();
    EXPECT_EQ(w.second->beside.shift(w.desk), glm::dvec3(5, 0, 0));
    EXPECT_EQ(std::get<Camera>(other.asked.camera).focalPoint,
              w.desk.camera().focalPoint + glm::dvec3(5, 0, 0));
    w.clickOn("of the same coordinates");
    w.frame();
    EXPECT_EQ(std::get<Camera>(other.asked.camera).focalPoint, w.desk.camera().focalPoint);
    w.viewing.seen->info.frameOfReference = other.seen->info.frameOfReference = "1.2.3";
    EXPECT_NE(w.second->beside.about(w.desk).find("same frame of reference"), std::string::npos);
}

TEST(WindowBeside, LookAndCutsAreLinkedAsAsked) {
    const VolumeSeen of = *test::pretendedVolume({400, 300});
    VolumeSeen other = movedScan(kBy);
    const TransferFunction own = TransferFunction::fromOpacity({{0, 0}, {9, 1}}, {{0, {1, 0, 0}}}, 1);
    other.scene.volumes.front().transferFunction = own;
    other.scene.window = GreyWindow{7, 9};
    other.scene.cuts.planes = {{{9, 9, 9}, {1, 0, 0}}};
    Scene scene = of.scene;
    scene.window = GreyWindow{40, 400};
    scene.cuts.planes = {{{1, 2, 3}, {0, 0, 1}}};
    const auto kinks = [](const Scene& s) {
        return std::get<TransferFunction>(s.volumes.front().transferFunction).kinks();
    };
    for (const bool look : {true, false})
        for (const bool cuts : {true, false}) {
            BesideLinks links;
            links.look = look;
            links.cuts = cuts;
            const Scene beside = sceneBeside(scene, of.info, other, links);
            EXPECT_EQ(kinks(beside) == own.kinks(), !look);
            EXPECT_EQ(beside.window == WindowChoice(GreyWindow{40, 400}), look);
            ASSERT_EQ(beside.cuts.planes.size(), 1u);
            EXPECT_EQ(beside.cuts.planes[0].point, cuts ? glm::dvec3(1, 2, 3) + kBy : glm::dvec3(9));
        }
}

// The value under the pointer is that of the scan that the pointer is over, which it names; and a place that
// is clicked there is the first scan's, moved.
TEST(WindowBeside, TheValueUnderThePointerIsOfItsScan) {
    HeadlessWindow w({1200, 700}, {{330, 0}, {300, 300}, 1});
    w.viewing.opened({300, 300});
    PretendedViewing& other = w.addSecond(kBy);
    w.viewing.answer = PickedPlace{0, true, {5, 6, 7}, {25, 30, 33}, 111, 0};
    other.answer = PickedPlace{0, true, glm::dvec3(1, 2, 3) + kBy, {25, 30, 33}, 222, 0};
    const auto restAt = [&](const glm::dvec2& at) {
        w.moveTo(at);
        w.moveTo(at + 1.0);
        std::this_thread::sleep_for(std::chrono::milliseconds(150));
        w.frame();
        w.frame();
    };
    restAt({400, 100});
    EXPECT_TRUE(w.shows("111")) << "of the first";
    EXPECT_FALSE(w.shows("222"));
    EXPECT_TRUE(w.shows("chest:"));
    const std::uint64_t picks = w.viewing.picks;
    restAt({330 + 300 + 70, 100});
    EXPECT_TRUE(w.shows("222")) << "of the second";
    EXPECT_FALSE(w.shows("111"));
    EXPECT_TRUE(w.shows("later:"));
    EXPECT_EQ(w.viewing.picks, picks);
    EXPECT_EQ(other.pickedAt, glm::dvec2(71, 101));
    // The ring there, and the cross at the same place of the first, which its camera sees there.
    glm::dvec2 pixel(0);
    ASSERT_TRUE(pictureFromPatient(w.desk.camera(), {300, 300}, {1, 2, 3}, pixel));
    const auto marked = [&](const glm::dvec2& at) {
        return std::any_of(w.drawn.begin(), w.drawn.end(), [&](const test::Drawn& d) {
            return d.words.empty() && d.right - d.left < 20 && d.bottom - d.top < 20 &&
                   std::abs(0.5f * (d.left + d.right) - static_cast<float>(at.x)) < 14 &&
                   std::abs(0.5f * (d.top + d.bottom) - static_cast<float>(at.y)) < 14;
        });
    };
    EXPECT_TRUE(marked(glm::dvec2(330, 0) + pixel));
    EXPECT_TRUE(marked(glm::dvec2(630, 0) + pixel));
    w.click({700, 100});
    w.click({700, 100});
    w.frame();
    w.frame();
    EXPECT_EQ(w.desk.camera().focalPoint, glm::dvec3(1, 2, 3)) << "a double click";
    EXPECT_EQ(w.desk.slices().placeMm, glm::dvec3(1, 2, 3));
}

// The planes of both go through one place, with one window where they have one unit.
TEST(WindowBeside, PlanesOfBothAreLinked) {
    for (const bool oneUnit : {true, false}) {
        HeadlessWindow w({1400, 700}, {{330, 0}, {300, 300}, 1});
        w.viewing.opened({300, 300});
        PretendedViewing& other = w.addSecond(kBy);
        other.seen->info.unit = oneUnit ? "HU" : "SUV";
        w.frame();
        SliceWish wish = w.desk.slices();
        wish.placeMm = {4, 5, 6};
        wish.window = {33, 44};
        w.desk.setSlices(wish);
        w.frame();
        const auto planesOf = [](const PretendedViewing& viewing) {
            std::string last;
            for (const std::string& said : viewing.said)
                if (said.rfind("planes", 0) == 0)
                    last = said;
            return last;
        };
        const glm::dvec3 there = glm::dvec3(4, 5, 6) + kBy;
        EXPECT_EQ(planesOf(other).find("planes through " + test::placeText(there) + ","), 0u)
            << planesOf(other);
        EXPECT_EQ(planesOf(other).find("C 33 W 44") != std::string::npos, oneUnit) << planesOf(other);
        EXPECT_NE(planesOf(other).find("120 x 98, 120 x 98, 120 x 98"), std::string::npos) << planesOf(other);
        // A hand at the other's axial plane moves the crosshair of both.
        const glm::dvec2 middle = w.second->planes.from + glm::dvec2(60, 49);
        w.click(middle);
        w.frame();
        const glm::dvec3 mm = w.desk.slices().placeMm;
        EXPECT_NE(mm, glm::dvec3(4, 5, 6));
        EXPECT_NEAR(mm.z, 6, 1e-9) << "in the plane";
        EXPECT_EQ(planesOf(other).find("planes through " + test::placeText(mm + kBy) + ","), 0u)
            << planesOf(other);
        // Its window is that of both, or its own.
        w.drag(middle, middle + glm::dvec2(0, 30), 1);
        EXPECT_EQ(w.desk.slices().window.centre == 33, !oneUnit);
        EXPECT_EQ(planesOf(other).find("C 33 W"), std::string::npos);
    }
}

// What is saved has both pictures, the other's with what belongs to it.
TEST(WindowBeside, SavedPicturesAreOfBoth) {
    Desk d;
    d.draw();
    auto owned = std::make_unique<PretendedViewing>();
    PretendedViewing& viewing = *owned;
    Beside beside(std::move(owned), "/scans/later.zarr");
    d.desk.setBeside(&beside);
    const std::filesystem::path file = "/tmp/both.png";
    d.desk.writeShown(file);
    EXPECT_EQ(d.viewing.said.back(), "screenshot both.png") << "nothing is there";
    beside.update(d.desk, {400, 300});
    viewing.opened({400, 300});
    viewing.seen->info.patientFromVoxel[3] += glm::dvec4(kBy, 0);
    beside.update(d.desk, {400, 300});
    Scene scene = d.desk.scene();
    scene.annotations.title = "before and after";
    scene.annotations.measurements = true;
    scene.annotations.arrows = {{{1, 2, 3}, {24, -24}, "here"}};
    scene.measurements = {{MeasurementKind::distance, {{0, 0, 0}, {1, 0, 0}}}};
    d.desk.setScene(scene, false);
    d.desk.savesScaleBar = true;
    beside.update(d.desk, {400, 300});
    d.desk.writeShown(file);
    EXPECT_EQ(d.viewing.said.back(), "screenshot both.png with a scale bar, and another with a scale bar");
    ASSERT_EQ(d.viewing.panels.size(), 1u);
    const PictureMarks& marks = d.viewing.panels[0].marks;
    EXPECT_EQ(marks.annotations.title, "before and after");
    EXPECT_FALSE(marks.annotations.measurements) << "they are of the first scan";
    EXPECT_TRUE(marks.annotations.arrows.empty()) << "they point at nothing of this one";
    beside.setLinks({.places = BesideLinks::Places::coordinates});
    ASSERT_EQ(beside.marks(d.desk).annotations.arrows.size(), 1u);
    EXPECT_EQ(beside.marks(d.desk).annotations.arrows[0].place, glm::dvec3(1, 2, 3));
    beside.setLinks({});
    EXPECT_EQ(d.viewing.panels[0].picture, viewing.drawn);
    d.desk.writeStill(file, 3);
    EXPECT_EQ(d.viewing.said.back(), "still both.png of 1200 x 900 with a scale bar, a panel");
    EXPECT_EQ(viewing.said.back(), "still both.png of 1200 x 900 with a scale bar, a panel");
    EXPECT_EQ(std::get<Camera>(viewing.still.camera).position, d.desk.camera().position + kBy);
}

// Both volumes may be open before the other one was asked for a picture: while the desk's camera is fitted.
TEST(WindowBeside, ThereMayBeNoPictureYet) {
    Desk d;
    d.draw();
    Beside beside(std::make_unique<PretendedViewing>(), "/scans/later.zarr");
    EXPECT_EQ(beside.camera(), nullptr);
    const FigurePart part = beside.overlay(d.desk);
    EXPECT_EQ(part.camera.position, d.desk.overlay().camera.position) << "neither is moved yet";
}

// A saved slice leaves out what lies beside its plane.
TEST(WindowBeside, ASavedSliceHasItsPlane) {
    Desk d;
    d.draw();
    EXPECT_FALSE(d.desk.marks().plane);
    Scene scene = d.desk.scene();
    scene.mode = Mode::slice;
    scene.slice = {.orientation = Orientation::coronal, .positionMm = 12.5};
    d.desk.setScene(scene, false);
    const auto plane = d.desk.marks().plane;
    ASSERT_TRUE(plane);
    EXPECT_EQ(plane->point.y, 12.5);
    EXPECT_NEAR(std::abs(plane->normal.y), 1, 1e-12);
    EXPECT_GT(plane->halfMm, 0);
    // As thick as a voxel along its normal, however voxels are numbered.
    VolumeInfo info = d.desk.volume()->info;
    for (const double sign : {1.0, -1.0}) {
        info.patientFromVoxel =
            glm::dmat4({2 * sign, 0, 0, 0}, {0, -3 * sign, 0, 0}, {0, 0, 5 * sign, 0}, {0, 0, 0, 1});
        for (const auto& [orientation, voxel] : {std::pair{Orientation::axial, 5.0},
                                                 {Orientation::coronal, 3.0},
                                                 {Orientation::sagittal, 2.0}}) {
            SlicePlane slice{.orientation = orientation};
            EXPECT_DOUBLE_EQ(planeOf(slice, info).halfMm, voxel / 2) << sign;
            slice.thicknessMm = 40;
            EXPECT_DOUBLE_EQ(planeOf(slice, info).halfMm, 20);
        }
    }
}

// A still that was just asked for is still to come, whatever the last state said.
TEST(WindowBeside, AStillIsAwaited) {
    Desk d;
    d.draw();
    d.viewing.now.atRest = true;
    d.draw();
    ASSERT_TRUE(d.desk.state().atRest);
    d.desk.writeStill("/tmp/one.png", 2);
    EXPECT_FALSE(d.desk.state().atRest);
}

// What goes wrong there is told at the desk, with the scan's name.
TEST(WindowBeside, ItsProblemsAreTold) {
    Desk d;
    auto owned = std::make_unique<PretendedViewing>();
    PretendedViewing& viewing = *owned;
    Beside beside(std::move(owned), "/scans/later.zarr");
    viewing.opened({400, 300});
    viewing.now.problem = "no room";
    beside.update(d.desk, {400, 300});
    ASSERT_TRUE(d.desk.message());
    EXPECT_EQ(d.desk.message()->text, "later: no room");
    EXPECT_TRUE(viewing.now.problem.empty());
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
