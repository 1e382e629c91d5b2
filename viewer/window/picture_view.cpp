// viewer/window/picture_view.cpp: see picture_view.h.
#include "viewer/window/picture_view.h"

#include "viewer/session/view_geometry.h"
#include "viewer/window/beside.h"
#include "viewer/window/function_edits.h"
#include "viewer/window/label_panel.h"

#include <algorithm>
#include <cmath>
#include <epoxy/gl.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <imgui.h>
#include <optional>
#include <utility>

namespace tessera {
namespace {

using namespace std::chrono_literals;
constexpr double kHalfTurnOfHeight = 3.14159265358979; // a drag over the picture's height turns by that
constexpr auto kRests = 120ms;                         // the pointer, before what is under it is asked

} // namespace

glm::ivec2 Area::pixels() const {
    return glm::max(glm::ivec2(glm::round(size * pixelsPerUnit)), glm::ivec2(1));
}

PictureTexture::PictureTexture() {
    glGenTextures(1, &name_);
    glBindTexture(GL_TEXTURE_2D, name_);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

PictureTexture::~PictureTexture() {
    glDeleteTextures(1, &name_);
}

void PictureTexture::show(const std::shared_ptr<const ShownPicture>& picture) {
    if (!picture || picture == shown_)
        return;
    glBindTexture(GL_TEXTURE_2D, name_);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    if (picture->displaySize != size_) {
        size_ = picture->displaySize;
        glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, size_.x, size_.y, 0, GL_RGBA, GL_UNSIGNED_BYTE,
                     picture->display.data());
    } else {
        glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, size_.x, size_.y, GL_RGBA, GL_UNSIGNED_BYTE,
                        picture->display.data());
    }
    shown_ = picture;
}

void PictureHand::drag(WindowState& desk, const Area& area, const glm::dvec2& delta) {
    const glm::dvec2 heights = delta / std::max(1.0, area.size.y);
    const Camera& camera = desk.camera();
    switch (drag_) {
    case Drag::orbit:
        desk.setCamera(orbited(camera, kHalfTurnOfHeight * glm::dvec2(-heights.x, -heights.y)), true);
        break;
    case Drag::pan:
        desk.setCamera(panned(camera, glm::dvec2(heights.x, -heights.y)), true);
        break;
    case Drag::zoom:
        desk.setCamera(zoomed(camera, std::exp2(-4 * heights.y)), true);
        break;
    case Drag::roll:
        desk.setCamera(rolled(camera, kHalfTurnOfHeight * heights.x), true);
        break;
    case Drag::window:
        if (const VolumeSeen* volume = desk.volume()) {
            const double range = volume->highest() - volume->lowest();
            desk.setFunction(
                shiftedAndStretched(desk.function(), 0.5 * range * heights.x, std::exp2(-2 * heights.y)),
                true);
        }
        break;
    case Drag::none:
        break;
    }
}

bool PictureHand::fly(WindowState& desk) {
    const auto held = [](int letter) {
        return ImGui::IsKeyDown(letter) ? 1.0 : 0.0;
    }; // GLFW's numbers are ASCII's
    const glm::dvec3 way(held('D') - held('A'), held('E') - held('Q'), held('W') - held('S'));
    const auto now = WindowClock::now();
    const double seconds = flewAt_ == WindowClock::time_point()
                               ? 0.0
                               : std::min(0.1, std::chrono::duration<double>(now - flewAt_).count());
    if (glm::dot(way, way) == 0) {
        flewAt_ = {};
        return false;
    }
    flewAt_ = now;
    const double faster = ImGui::GetIO().KeyShift ? 4 : 1;
    const double mmPerSecond = faster * std::max(5.0, 0.25 * focalDistanceMm(desk.camera()));
    desk.setCamera(flown(desk.camera(), seconds * mmPerSecond * way, glm::dvec2(0)), true);
    return true;
}

void PictureHand::press(WindowState& desk, int key, bool control, bool shift) {
    if (!desk.volume())
        return;
    if (control) {
        if (key == 'Z' && !shift)
            desk.undo();
        else if (key == 'Y' || key == 'Z')
            desk.redo();
        else if (key == 'S')
            desk.saveScene();
        return;
    }
    constexpr View kViews[] = {View::anterior, View::posterior, View::left,
                               View::right,    View::superior,  View::inferior};
    if (key >= '1' && key <= '6')
        desk.fitView(kViews[key - '1']);
    else if (key == 'R')
        desk.fitView();
    else if (key == 'P')
        desk.setProjection(desk.camera().projection == Projection::parallel ? Projection::perspective
                                                                            : Projection::parallel);
    else if (key == 'F')
        desk.flying = !desk.flying;
}

bool PictureHand::handle(WindowState& desk, const Area& area, Beside* beside) {
    if (std::exchange(beside_, beside) != beside) { // what was asked is of the other picture
        pickedAt_ = {-1, -1};
        centreOn_ = aloneOn_ = 0;
    }
    Viewing& viewing = beside ? beside->viewing() : desk.viewing();
    const ImGuiIO& io = ImGui::GetIO();
    const glm::dvec2 mouse(io.MousePos.x, io.MousePos.y);
    over_ = !io.WantCaptureMouse && mouse.x >= area.from.x && mouse.y >= area.from.y &&
            mouse.x < area.from.x + area.size.x && mouse.y < area.from.y + area.size.y;
    const auto now = WindowClock::now();
    if (io.MouseDelta.x != 0 || io.MouseDelta.y != 0)
        pointerMoved_ = now;
    pointer_ = area.pictureFromWindow(mouse);
    if (!desk.volume())
        return false;
    if (over_ && drag_ == Drag::none) {
        const bool left = ImGui::IsMouseClicked(0), right = ImGui::IsMouseClicked(1),
                   middle = ImGui::IsMouseClicked(2);
        if (left && io.KeyCtrl && io.KeyShift && desk.volume()->labels && !beside)
            aloneOn_ = viewing.pick(pointer_);
        else if (left && ImGui::IsMouseDoubleClicked(0))
            centreOn_ = viewing.pick(pointer_);
        else if (middle || (left && io.KeyShift))
            drag_ = Drag::pan;
        else if (left && io.KeyCtrl)
            drag_ = Drag::roll;
        else if (left && io.KeyAlt)
            drag_ = Drag::window, desk.beginEdit();
        else if (left)
            drag_ = Drag::orbit;
        else if (right)
            drag_ = Drag::zoom;
        if (io.MouseWheel != 0) {
            const glm::dvec2 place =
                (pointer_ - 0.5 * glm::dvec2(area.pixels())) / static_cast<double>(area.pixels().y);
            desk.setCamera(
                zoomedAt(desk.camera(), std::exp2(0.25 * static_cast<double>(io.MouseWheel)), place), true);
        }
    }
    if (drag_ != Drag::none && !ImGui::IsMouseDown(0) && !ImGui::IsMouseDown(1) && !ImGui::IsMouseDown(2))
        drag_ = Drag::none;
    if (drag_ != Drag::none && (io.MouseDelta.x != 0 || io.MouseDelta.y != 0)) {
        const glm::dvec2 delta(io.MouseDelta.x, io.MouseDelta.y);
        if (desk.flying && drag_ == Drag::orbit)
            desk.setCamera(
                flown(desk.camera(), glm::dvec3(0),
                      glm::radians(desk.camera().viewAngle) / area.size.y * glm::dvec2(delta.x, -delta.y)),
                true);
        else
            drag(desk, area, delta);
    }
    const std::optional<PickedPlace>& picked = beside ? beside->picked() : desk.picked();
    if (picked && centreOn_ != 0 && picked->number >= centreOn_) {
        centreOn_ = 0;
        if (picked->hit) {
            const glm::dvec3 mm = beside ? picked->mm - beside->shift(desk) : picked->mm;
            SliceWish planes = desk.slices();
            planes.placeMm = mm;
            desk.setSlices(planes);
            desk.setCamera(centredOn(desk.camera(), mm), false);
        } else
            desk.tell("nothing is visible there");
    }
    if (picked && aloneOn_ != 0 && picked->number >= aloneOn_) {
        aloneOn_ = 0;
        showAlone(desk, PickedPlace(*picked)); // a copy: another scene drops it
    }
    const bool another = pickedAt_ != pointer_ || pickedFor_ != desk.asked();
    const bool rests = now - pointerMoved_ > kRests && desk.hasAsked();
    if (over_ && drag_ == Drag::none && another && rests) {
        pickedAt_ = pointer_;
        pickedFor_ = desk.asked();
        viewing.pick(pointer_);
    }
    return (desk.flying && !io.WantTextInput && fly(desk)) || (over_ && another && !rests);
}

} // namespace tessera
