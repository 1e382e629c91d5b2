// viewer/window/endoscopy.h: the endoscopy panel. Clicks ask for a centre-line; the user flies along it and
// makes a film of it. The path is the very one of `tessera render --path`: what is recorded here
// is drawn there.
#pragma once

#include "core/animation/film.h"
#include "viewer/session/slice_frame.h"
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
    /// Takes what was found, and flies on. Once a frame. Returns whether it moves on its own.
    bool advance(WindowState& desk);
    /// Looking around while a line is flown. Returns whether it takes the mouse.
    bool handle(WindowState& desk, const Area& area);
    /// A key, as GLFW names it; true where it is one of these.
    bool press(WindowState& desk, int key, bool shift);
    /// A place on a plane was clicked. Returns whether it is one of a line's.
    bool placed(WindowState& desk, const glm::dvec3& mm);
    /// Nothing is gathered, looked for or flown any more.
    void stop(WindowState& desk);
    void panel(WindowState& desk);
    /// The line, the places that were clicked, and while a line is flown a map of where one is.
    void draw(WindowState& desk, const Area& area) const;
    /// Whether to fly along a line that may have left the lumen, where that is asked. Over the picture.
    void drawQuestion(WindowState& desk, const Area& area);
    /// What of the lines lies in a plane, on its picture.
    void drawOnPlane(ImDrawList& draw, const Area& view, const SliceFrame& frame) const;

    /// Looks for a line through places, mm.
    void find(WindowState& desk, const std::vector<glm::dvec3>& places, bool tree);
    /// Throws Error or InputError.
    void load(WindowState& desk, const std::filesystem::path& file);
    void save(WindowState& desk, const std::filesystem::path& file);
    /// Measures what of the wall the flight sees.
    void measureCoverage(WindowState& desk, bool bothWays);
    /// To where an unseen patch is seen; from 0, the largest first. Nothing where there is none.
    void lookAtPatch(WindowState& desk, std::size_t patch);
    /// Along the flight, mm; held to it.
    void flyTo(WindowState& desk, double mm);
    void play(WindowState& desk, bool on);
    /// The view of now becomes a keyframe of the flight: where one looks, and what the scene looks like
    /// where that was changed.
    void record(WindowState& desk);
    /// A line that may have left the lumen is not flown before somebody says so: all of it, or to where it
    /// may have left.
    enum class Answer { fly, stop, cancel };
    bool asks() const { return question_.has_value(); }
    /// Of the question that is asked; nothing where none is. stop is fly where nobody knows where.
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
    std::uint64_t wish_ = 0;          // the line that was asked for
    std::optional<double> threshold_; // that the user set
    struct Question {
        bool plays = false; // what is to be done: fly on, or look at the place
    };
    std::optional<Question> question_;
    bool trusted_ = false; // the question of this path was answered
    double placeMm_ = 0;
    double shownThreshold_ = 0;      // that the line was found with
    std::optional<LookAround> look_; // in place of the keyframes'
    bool looks_ = false;             // a drag looks around
    WindowClock::time_point flewAt_;
    const VolumeSeen* of_ = nullptr;
    char file_[256] = {};
};

} // namespace tessera
