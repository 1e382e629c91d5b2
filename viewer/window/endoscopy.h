// viewer/window/endoscopy.h: the endoscopy panel. Clicks request a centre-line; the user flies along it and
// records a film. The path is that of `tessera render --path`: keyframes recorded here are drawn there.
#pragma once

#include "core/animation/film.h"
#include "viewer/session/view_geometry.h"
#include "viewer/window/picture_view.h" // Area
#include "viewer/window/window_state.h"

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

struct ImDrawList;

namespace tessera {

class Endoscopy {
  public:
    /// Takes results, and continues the flight. Called once a frame. Returns true if the camera moves on its
    /// own.
    bool advance(WindowState& desk);
    /// Looking around during a flight. Returns true if it takes the mouse.
    bool handle(WindowState& desk, const Area& area);
    /// Handles a key by GLFW's name; true if it is one of the panel's.
    bool press(WindowState& desk, int key, bool shift);
    /// Handles a click on a plane. Returns true if it is a point of a line.
    bool placed(WindowState& desk, const glm::dvec3& mm);
    /// Ends clicks, search and flight.
    void stop(WindowState& desk);
    void panel(WindowState& desk);
    /// Draws the line, the clicked points, and during a flight a map with the position.
    void draw(WindowState& desk, const Area& area) const;
    /// The question whether to fly along a line that may have left the lumen. Over the picture.
    void drawQuestion(WindowState& desk, const Area& area);
    /// Draws the parts of the lines in a plane, on its picture.
    void drawOnPlane(ImDrawList& draw, const Area& view, const SliceFrame& frame) const;

    /// Requests a line through points, mm.
    void find(WindowState& desk, const std::vector<glm::dvec3>& places, bool tree);
    /// Throws Error or InputError.
    void load(WindowState& desk, const std::filesystem::path& file);
    void save(WindowState& desk, const std::filesystem::path& file);
    /// Requests the wall coverage of the flight.
    void measureCoverage(WindowState& desk, bool bothWays);
    /// Moves to a view of an unseen patch, by its number from 0, the largest first. No effect if there is
    /// none.
    void lookAtPatch(WindowState& desk, std::size_t patch);
    /// Moves along the flight, mm; clamped to it.
    void flyTo(WindowState& desk, double mm);
    void play(WindowState& desk, bool on);
    /// Records the current view as a keyframe of the flight: view direction, and changed settings of the
    /// scene.
    void record(WindowState& desk);
    /// The user must confirm a flight along a line that may have left the lumen: all of it, or to where it
    /// may have left.
    enum class Answer { fly, stop, cancel };
    bool asks() const { return question_.has_value(); }
    /// Answers the open question, if any. stop is fly if the place is unknown.
    void answer(WindowState& desk, Answer answer);
    bool isSearching() const { return searching_; }
    bool isPlaying() const { return playing_; }
    bool hasLine() const { return curve_.has_value(); }
    double lengthMm() const { return curve_ ? curve_->lengthMm() : 0; }

  private:
    void take(WindowState& desk, const Path& path);
    void takeAnother(WindowState& desk, const Path& path);
    void flyAnew(WindowState& desk);
    void show(WindowState& desk, bool moving);
    void showWall(WindowState& desk);
    void searchPanel(WindowState& desk);
    void flightPanel(WindowState& desk);
    void keyframePanel(WindowState& desk);
    void coveragePanel(WindowState& desk);
    std::span<const UnseenPatch> unseen() const;
    std::string doubt() const;
    std::optional<double> stopMm() const;
    bool mayFly();
    void drawMap(ImDrawList& draw, const WindowState& desk, const Area& area) const;

    std::optional<Path> path_;
    std::optional<FlightCurve> curve_;
    std::optional<Film> film_; // of path_; none: it has changed since
    std::string about_;
    std::shared_ptr<const WallCoverage> coverage_; // of this path and flight
    std::string coverageAbout_;
    bool bothWays_ = false;
    std::vector<glm::dvec3> places_; // clicked so far
    bool gathers_ = false, tree_ = false, searching_ = false, inside_ = false, playing_ = false;
    std::uint64_t wish_ = 0;          // the requested line
    std::optional<double> threshold_; // set by the user
    struct Question {
        bool plays = false; // pending action: fly, or look at a point
    };
    std::optional<Question> question_;
    bool trusted_ = false; // the question of this path was answered
    double placeMm_ = 0;
    double shownThreshold_ = 0;      // of the found line
    std::optional<LookAround> look_; // in place of the keyframes'
    bool looks_ = false;             // a drag looks around
    WindowClock::time_point flewAt_;
    const VolumeSeen* of_ = nullptr;
    char file_[256] = {};
};

} // namespace tessera
