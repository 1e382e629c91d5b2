// tests/viewer/window/window_sharp_test.cpp: a screen of 1.6 pixels a unit, with a picture that begins at no
// corner and is no square, of a volume that lies askew: what is drawn and what a hand does there is what is
// recorded (tests/support/window_record.h).
#include "tests/support/pretended_path.h"
#include "tests/support/window_record.h"
#include "viewer/session/view_geometry.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

namespace tessera::test {
namespace {

/// 41 x 53 x 37 voxels of 0.9 x 1.1 x 1.7 mm, turned by 25 degrees about (1, 2, 3).
std::shared_ptr<VolumeSeen> askewVolume(const glm::ivec2& pictureSize) {
    auto seen = pretendedVolume(pictureSize);
    seen->info.extentVoxels = {41, 53, 37};
    const glm::dmat4 turned = glm::rotate(glm::dmat4(1), glm::radians(25.0), glm::dvec3(1, 2, 3));
    seen->info.patientFromVoxel = glm::translate(glm::dmat4(1), glm::dvec3(3, -4, 11)) * turned *
                                  glm::scale(glm::dmat4(1), glm::dvec3(0.9, 1.1, 1.7)) *
                                  glm::translate(glm::dmat4(1), -glm::dvec3(41, 53, 37) / 2.0);
    seen->info.remarks.clear();
    seen->values.lowest = -850, seen->values.highest = 1900;
    return seen;
}

class SharpWindow : public HeadlessWindow {
  public:
    SharpWindow() : HeadlessWindow({1010, 640}, {{90, 35}, {520, 430}, 1.6}) {
        desk.showPanels = false;
        viewing.opened(area.pixels());
        viewing.seen = askewVolume(area.pixels());
        viewing.drawn->camera = std::get<Camera>(viewing.seen->scene.camera);
    }
    void keyed(bool ImGuiIO::*key, const std::function<void()>& act) {
        ImGui::GetIO().*key = true;
        act();
        ImGui::GetIO().*key = false;
    }
};

TEST(WindowDrawn, SharpPicture) {
    SharpWindow w;
    w.desk.showSlices = false;
    w.step("open", [] {});
    const glm::dvec2 at(300, 200), to(345, 165);
    w.step("orbit", [&] { w.drag(at, to); });
    w.step("zoom", [&] { w.drag(at, to, 1); });
    w.step("pan", [&] { w.drag(at, to, 2); });
    w.step("roll", [&] { w.keyed(&ImGuiIO::KeyCtrl, [&] { w.drag(at, to); }); });
    w.step("window", [&] { w.keyed(&ImGuiIO::KeyAlt, [&] { w.drag(at, to); }); });
    w.step("wheel", [&] { w.wheel(at, -3); });
    w.step("in parallel", [&] { w.desk.setProjection(Projection::parallel); });
    w.step("pan in parallel", [&] { w.drag(at, to, 2); });
    w.step("wheel in parallel", [&] { w.wheel({500, 400}, 2); });
    w.step("fit", [&] { w.hand.press(w.desk, 'R', false, false); });
    w.step("legend", [&] { w.desk.showLegend = true; });
    w.step("levels", [&] {
        w.desk.showLevels = true;
        w.viewing.now.brickGrid = {2, 2, 2};
        w.viewing.now.levels =
            std::make_shared<std::vector<std::uint8_t>>(std::vector<std::uint8_t>{5, 4, 3, 2, 1, 0, 6, 255});
    });
    w.step("a message", [&] { w.desk.tell("a sentence that says what happened, in some words"); });
    w.step("nothing is open", [&] {
        w.viewing.now.kind = ViewingState::Kind::opening, w.viewing.now.what = "reading",
        w.viewing.now.share = 0.7;
    });
    compareWithRecord(w, "sharp-picture");
}

TEST(WindowDrawn, SharpTools) {
    SharpWindow w;
    w.desk.showSlices = false;
    w.step("open", [] {});
    w.viewing.answer = PickedPlace{0, true, {5, 6, 7}, {25, 30, 33}, 123.4, 0};
    const auto measured = [&](Tools::Tool tool, const std::vector<glm::dvec3>& places) {
        w.tools.take(tool);
        for (std::size_t n = 0; n < places.size(); ++n)
            w.step("place " + std::to_string(n), [&] {
                w.viewing.answer->mm = places[n];
                w.click({200 + 30.0 * static_cast<double>(n), 200});
                EXPECT_EQ(w.viewing.pickedAt, 1.6 * glm::dvec2(110 + 30.0 * static_cast<double>(n), 165));
            });
    };
    measured(Tools::Tool::distance, {{-10, 3, 0}, {10, -5, 20}});
    measured(Tools::Tool::angle, {{-10, 0, -30}, {10, -5, -20}, {15, 0, -40}});
    measured(Tools::Tool::circle, {{-15, 0, 30}, {0, -5, 40}, {15, 0, 35}});
    w.tools.stop();
    w.step("scissors", [&] {
        w.tools.take(Tools::Tool::scissorsOutside);
        w.moveTo({300, 150});
        w.button(0, true);
        for (const glm::dvec2 p : {glm::dvec2(420, 160), {430, 300}, {310, 320}})
            w.moveTo(p);
        w.button(0, false);
    });
    w.tools.stop();
    Scene clear = w.desk.scene();
    clear.cuts = {}, clear.measurements = {};
    w.desk.setScene(clear, false);
    w.step("box", [&] { w.cuts.toggleBox(w.desk); });
    const auto handles = [&] { return handlesOfBox(w); };
    ASSERT_EQ(handles().size(), 6u);
    for (std::size_t n = 0; n < 6; ++n)
        w.step("side " + std::to_string(n), [&] {
            const glm::dvec2 from = glm::round(handles()[n]);
            w.drag(from + 2.0, from + glm::round(0.3 * (glm::dvec2(350, 250) - from)) + 2.0);
        });
    w.step("no box", [&] { w.cuts.toggleBox(w.desk); });
    w.step("plane", [&] { w.cuts.addPlane(w.desk); });
    w.step("seen from the side", [&] { w.desk.setCamera(orbited(w.desk.camera(), {0.5, -0.4}), false); });
    const auto plane = [&] { return handleOfPlane(w); };
    w.step("plane is pushed", [&] { w.drag(plane(), plane() + glm::dvec2(35, 20)); });
    compareWithRecord(w, "sharp-tools");
}

TEST(WindowDrawn, SharpPlanes) {
    SharpWindow w;
    w.step("open", [] {});
    w.step("drawn", [&] {
        auto shown = std::make_shared<ShownSlices>();
        shown->wish = w.desk.slices();
        for (std::size_t n = 0; n < 3; ++n) {
            shown->planes[n].frame.size = shown->wish.sizes[n];
            shown->planes[n].display.resize(static_cast<std::size_t>(shown->wish.sizes[n].x) *
                                            static_cast<std::size_t>(shown->wish.sizes[n].y));
        }
        shown->fine = true;
        shown->value = -42.25;
        w.viewing.planes = shown;
    });
    for (int n = 0; n < 3; ++n) {
        const glm::dvec2 at(790, 85 + 140 * n);
        w.step("crosshair " + std::to_string(n), [&] { w.drag(at, at + glm::dvec2(23, 11)); });
        w.step("wheel " + std::to_string(n), [&] { w.wheel(at, -3); });
        w.step("window " + std::to_string(n), [&] { w.drag(at, at + glm::dvec2(30, -17), 1); });
    }
    w.step("zoom", [&] { w.keyed(&ImGuiIO::KeyCtrl, [&] { w.wheel({800, 80}, 4); }); });
    w.step("crosshair, zoomed", [&] { w.drag({800, 230}, {777, 250}); });
    w.step("a line", [&] {
        w.endoscopy.find(w.desk, {{1, 2, 3}}, false);
        foundLine(w.viewing, false);
    });
    w.step("coverage", [&] {
        w.endoscopy.measureCoverage(w.desk, true);
        foundCoverage(w.viewing);
    });
    w.step("a flight", [&] { w.endoscopy.flyTo(w.desk, 33); });
    w.step("measurements", [&] {
        Scene scene = w.desk.scene();
        const glm::dvec3 p = w.desk.slices().placeMm;
        scene.measurements = {
            {MeasurementKind::distance, {p, p + glm::dvec3(10, 5, 0)}},
            {MeasurementKind::angle, {p, p + glm::dvec3(0, 5, 10), p + glm::dvec3(4, 5, 1)}}};
        w.desk.setScene(scene, false);
    });
    w.step("one alone", [&] {
        w.click({800, 390});
        w.click({800, 390});
    });
    w.step("border", [&] { w.drag({611, 300}, {500, 310}); });
    compareWithRecord(w, "sharp-planes");
}

} // namespace
} // namespace tessera::test
