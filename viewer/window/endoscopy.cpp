// viewer/window/endoscopy.cpp: see endoscopy.h: how a line is found, flown and recorded. Its panel and what
// is drawn of it: endoscopy_panel.cpp.
#include "viewer/window/endoscopy.h"

#include "core/animation/flight.h"
#include "core/animation/path.h"
#include "core/base/error.h"
#include "core/base/output_file.h"
#include "core/scene/preset.h"
#include "viewer/paths/path_file.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/common.hpp>
#include <imgui.h>

namespace tessera {
namespace {

constexpr double kStepMm = 5;       // of the arrow keys
constexpr double kSteerMm = 1;      // of Shift and the arrow keys
constexpr double kMostPitch = 85;   // degrees
constexpr double kAheadSeconds = 2; // whose bricks are read ahead
constexpr int kAheadCameras = 8;
// As GLFW numbers them.
constexpr int kSpace = 32, kEnter = 257, kRight = 262, kLeft = 263, kDown = 264, kUp = 265, kHome = 268;

} // namespace

void Endoscopy::find(WindowState& desk, const std::vector<glm::dvec3>& places, bool tree) {
    LineWish wish;
    wish.places = places;
    wish.tree = tree;
    wish.threshold = threshold_;
    wish_ = desk.viewing().findLine(wish);
    searching_ = true;
    gathers_ = false;
}

void Endoscopy::take(WindowState& desk, const Path& path) {
    path_ = path;
    if (!path_->flight)
        path_->flight.emplace();
    film_.reset();
    coverage_.reset();
    curve_.emplace(path_->lines, *path_->flight);
    placeMm_ = std::min(placeMm_, curve_->lengthMm());
    if (inside_)
        show(desk, false);
}

/// A new path, not flown yet.
void Endoscopy::takeAnother(WindowState& desk, const Path& path) {
    question_.reset();
    trusted_ = false;
    if (path.lumen && !doubtText(*path.lumen).empty())
        playing_ = inside_ = false;
    take(desk, path);
}

void Endoscopy::load(WindowState& desk, const std::filesystem::path& file) {
    Path path = loadPathFile(file);
    if (path.lines.empty())
        throw badFile(file.string(), "a path with a centre-line", "keyframes alone");
    if (path.volume && path.volume->extentVoxels != desk.volume()->info.extentVoxels)
        throw badFile(file.string(), "a path of a volume of this size", "one of another volume");
    about_ = "from " + file.filename().string() + ": " + linesText(path.lines);
    placeMm_ = 0;
    look_.reset();
    takeAnother(desk, path);
}

void Endoscopy::save(WindowState& desk, const std::filesystem::path& file) {
    if (!path_)
        throw InputError("there is no line to save");
    writeOutputFile(file, pathJson(*path_));
    desk.tell("wrote " + file.string() + "; tessera render SCENE --path " + file.string() + " -o film.mp4");
}

void Endoscopy::flyAnew(WindowState& desk) {
    take(desk, *path_);
}

/// Shows the lumen's wall: the default functions show bones and organs from outside, and few functions show
/// the wall.
void Endoscopy::showWall(WindowState& desk) {
    if (!path_ || !path_->lumen)
        return;
    Scene scene = desk.scene();
    if (!showLumenWall(*path_->lumen, scene))
        return;
    desk.beginEdit();
    desk.setScene(scene, false);
    char words[160];
    std::snprintf(words, sizeof words,
                  "the wall is an isosurface at %.0f %s (Mode and Isosurfaces; Ctrl Z undoes it)",
                  path_->lumen->shownAt(), desk.volume()->info.unit.c_str());
    desk.tell(words);
}

/// The film's frame at this position, in the current direction.
void Endoscopy::show(WindowState& desk, bool moving) {
    if (!curve_ || !mayFly())
        return;
    if (!inside_ && desk.scene().mode == Mode::composite && desk.scene().surfaces.empty())
        showWall(desk);
    inside_ = true;
    const Flight& flight = *path_->flight;
    const double seconds = placeMm_ / flight.speedMmPerS;
    if (!film_)
        film_.emplace(
            *path_, desk.scene(),
            [values = desk.volume()->values](const std::string& name) {
                return presetFunction(name, values);
            },
            "path");
    Scene scene = desk.scene();
    scene.camera = film_->cameraAt(seconds);
    if (!film_->onlyCameraMoves()) { // keyframes set other parts of the scene
        const Scene said = film_->sceneAt(seconds);
        scene.volumes = said.volumes;
        scene.lighting = said.lighting;
        scene.cuts = said.cuts;
    }
    if (look_)
        scene.camera = cameraOf(curve_->at(placeMm_), *look_, flight);
    SliceWish planes = desk.slices();
    planes.placeMm = std::get<Camera>(scene.camera).position;
    desk.setSlices(planes);
    desk.setScene(scene, moving);
    std::vector<Camera> ahead;
    for (int i = 1; moving && i <= kAheadCameras; ++i)
        ahead.push_back(cameraOf(
            curve_->at(placeMm_ + i * kAheadSeconds / kAheadCameras * flight.speedMmPerS), {}, flight));
    desk.viewing().lookAhead(std::move(ahead));
}

void Endoscopy::flyTo(WindowState& desk, double mm) {
    if (!curve_)
        return;
    placeMm_ = std::clamp(mm, 0.0, curve_->lengthMm());
    show(desk, true);
}

void Endoscopy::play(WindowState& desk, bool on) {
    if (!curve_ || on == playing_)
        return;
    playing_ = on;
    flewAt_ = {};
    if (on && placeMm_ >= curve_->lengthMm())
        placeMm_ = 0;
    show(desk, on);
}

void Endoscopy::record(WindowState& desk) {
    if (!curve_)
        return;
    const Flight& flight = *path_->flight;
    Keyframe key;
    // Along the route, which may be flown backwards and from somewhere on.
    key.placeMm = flight.backwards ? flight.fromMm + curve_->lengthMm() - placeMm_ : flight.fromMm + placeMm_;
    key.look = look_.value_or(LookAround{});
    key.transferFunction = desk.function();
    key.lighting = desk.scene().lighting;
    key.cuts = desk.scene().cuts;
    auto& keys = path_->keyframes;
    const auto sameOrLater = [&](const Keyframe& k) {
        return flight.backwards ? *k.placeMm <= *key.placeMm : *k.placeMm >= *key.placeMm;
    };
    const auto at = std::find_if(keys.begin(), keys.end(), sameOrLater);
    if (at != keys.end() && std::abs(*at->placeMm - *key.placeMm) < 1e-3)
        *at = key;
    else
        keys.insert(at, key);
    film_.reset();
}

void Endoscopy::measureCoverage(WindowState& desk, bool bothWays) {
    if (!path_ || !path_->lumen)
        throw InputError("there is no line whose lumen is known");
    LineWish wish;
    wish.seenAlong = std::make_shared<Path>(*path_);
    wish.aspect = static_cast<double>(desk.scene().imageSize.x) / desk.scene().imageSize.y;
    wish.bothWays = bothWays;
    wish_ = desk.viewing().findLine(wish);
    searching_ = true;
    gathers_ = false;
}

/// Looks back at the patch from its far end, because most patches are hidden from the front.
void Endoscopy::lookAtPatch(WindowState& desk, std::size_t patch) {
    if (!coverage_ || patch >= coverage_->patches.size() || !curve_)
        return;
    const UnseenPatch& p = coverage_->patches[patch];
    const Flight& flight = *path_->flight;
    const double along =
        flight.backwards ? flight.fromMm + curve_->lengthMm() - p.fromMm : p.toMm - flight.fromMm;
    placeMm_ = std::clamp(along, 0.0, curve_->lengthMm());
    look_ = lookTowards(curve_->at(placeMm_), p.middleMm);
    show(desk, false);
}

bool Endoscopy::advance(WindowState& desk) {
    if (of_ != desk.volume()) { // another volume: all state of the old one is invalid
        *this = {};
        of_ = desk.volume();
    }
    if (!of_)
        return false;
    const LineState line = desk.viewing().line();
    if (searching_ && !line.searching && line.number == wish_) {
        searching_ = false;
        if (line.path) {
            about_ = line.about;
            placeMm_ = 0;
            look_.reset();
            if (!threshold_ && line.path->lumen)
                shownThreshold_ = line.path->lumen->threshold;
            takeAnother(desk, *line.path);
            if (inside_) // from outside the overlay on the picture shows it
                desk.tell(about_);
        } else if (line.coverage) {
            coverage_ = line.coverage;
            coverageAbout_ = line.about;
            desk.tell(coverageAbout_);
        } else if (!line.problem.empty()) {
            desk.tell(line.problem, true);
        }
    }
    if (!playing_ || !curve_)
        return searching_;
    // No picture is requested before the previous one is drawn: a slow machine flies at the same speed in
    // larger steps.
    const auto now = WindowClock::now();
    if (flewAt_ == WindowClock::time_point())
        flewAt_ = now;
    if (!desk.isAnswered())
        return true;
    const double seconds = std::chrono::duration<double>(now - flewAt_).count();
    flewAt_ = now;
    placeMm_ += seconds * path_->flight->speedMmPerS;
    if (placeMm_ >= curve_->lengthMm()) {
        placeMm_ = curve_->lengthMm();
        playing_ = false;
    }
    show(desk, playing_);
    return true;
}

bool Endoscopy::handle(WindowState& desk, const Area& area) {
    if (!desk.volume())
        return false;
    const ImGuiIO& io = ImGui::GetIO();
    const glm::dvec2 place = area.pictureFromWindow({io.MousePos.x, io.MousePos.y}), size(area.pixels());
    const bool over =
        !io.WantCaptureMouse && place.x >= 0 && place.y >= 0 && place.x < size.x && place.y < size.y;
    if (gathers_ && over && ImGui::IsMouseClicked(0)) { // a click here would meet a wall, not the lumen
        desk.tell("click in the lumen, on a plane");
        return true;
    }
    if (!inside_ || !curve_)
        return false;
    if (over && ImGui::IsMouseClicked(0) && !io.KeyShift && !io.KeyCtrl && !io.KeyAlt)
        looks_ = true;
    if (!looks_)
        return false;
    if (!ImGui::IsMouseDown(0)) {
        looks_ = false;
        if (!playing_)
            show(desk, false);
        return true;
    }
    if (io.MouseDelta.x != 0 || io.MouseDelta.y != 0) {
        const double degrees = path_->flight->viewAngle / area.size.y;
        LookAround look = look_.value_or(LookAround{});
        look.yawDegrees -= degrees * static_cast<double>(io.MouseDelta.x);
        look.pitchDegrees = std::clamp(look.pitchDegrees + degrees * static_cast<double>(io.MouseDelta.y),
                                       -kMostPitch, kMostPitch);
        look_ = look;
        show(desk, true);
    }
    return true;
}

bool Endoscopy::placed(WindowState& desk, const glm::dvec3& mm) {
    if (!gathers_)
        return false;
    places_.push_back(mm);
    if (tree_)
        find(desk, places_, true);
    return true;
}

bool Endoscopy::press(WindowState& desk, int key, bool shift) {
    if (gathers_ && key == kEnter && !places_.empty()) {
        find(desk, places_, tree_);
        return true;
    }
    if (!curve_)
        return false;
    const auto steer = [&](const glm::dvec2& by) {
        LookAround look = look_.value_or(LookAround{});
        look.offsetMm += kSteerMm * by;
        look_ = look;
        show(desk, false);
    };
    switch (key) {
    case kSpace:
        play(desk, !playing_);
        return true;
    case kHome:
        look_.reset();
        show(desk, false);
        return true;
    case kRight:
    case kLeft:
        if (shift)
            steer({key == kRight ? 1 : -1, 0});
        else
            flyTo(desk, placeMm_ + (key == kRight ? kStepMm : -kStepMm));
        return true;
    case kUp:
    case kDown:
        steer({0, key == kUp ? 1 : -1});
        return true;
    default:
        return false;
    }
}

void Endoscopy::stop(WindowState& desk) {
    question_.reset();
    gathers_ = false;
    places_.clear();
    if (searching_)
        desk.viewing().callOffLine();
    playing_ = false;
}

} // namespace tessera
