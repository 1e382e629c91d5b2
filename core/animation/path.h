// core/animation/path.h: paths through a volume, as a value and as a JSON file (docs/path.schema.json). A
// path has centre-lines of hollow organs, keyframes, and the parameters of a flight; core/animation/flight.h
// makes its curve. Texts about its centre-lines are for commands and windows.
#pragma once

#include "core/scene/camera.h"
#include "core/scene/cuts.h"
#include "core/scene/lighting.h"
#include "core/scene/scene.h" // TransferChoice

#include <cstddef>
#include <filesystem>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

/// One branch of a hollow organ's centre-line: evenly spaced points in patient space.
struct CentreLine {
    std::string name;               // a name for people; may be empty
    std::vector<glm::dvec3> points; // mm, LPS; at least kFewestPoints
    std::vector<double> radiusMm;   // distance to the wall, one for every point, 0 or more
    double spacingMm = 0;           // between points, along the line; straight distances are not longer
    std::optional<std::size_t> parent = {}; // the parent line, an earlier one
    double leavesAtMm = 0;                  // where it leaves the parent: along it, from its first point

    static constexpr std::size_t kFewestPoints = 2;
    double lengthMm() const { return spacingMm * static_cast<double>(points.size() - 1); }
    bool operator==(const CentreLine&) const = default;
};

/// The values that counted as lumen when the lines were made: one side of a threshold.
struct Lumen {
    enum class Side { below, above };
    double threshold = 0; // physical units
    Side side = Side::below;
    double noise = 0;   // standard deviation of the noise that was removed from the values first; 0: none
    bool leaks = false; // the lumen leaks through its wall, and the user was told
    /// Of a leaking lumen: where, along the first line, it leaves the lumen of a threshold that does not
    /// leak. None: it does not, or this is unknown.
    std::optional<double> leavesAtMm = {};
    bool unsure = false; // the threshold hardly differs from the noise of values in the lumen
    /// Isovalue that shows the wall in the volume's own values, with their noise. None: the threshold.
    std::optional<double> surface = {};
    /// Value up to which thin branches of a tree were followed beyond the threshold. None: no such branches.
    std::optional<double> branchesTo = {};
    /// Least difference between the values around a thin branch, its wall, and its own; physical units.
    std::optional<double> branchWall = {};
    double shownAt() const { return surface.value_or(threshold); }
    bool operator==(const Lumen&) const = default;
};

/// The volume in which the lines were made.
struct PathVolume {
    std::string contentHash; // StoreReader::contentHash()
    glm::ivec3 extentVoxels{0};
    bool operator==(const PathVolume&) const = default;
};

/// The transition from one keyframe to the next. through: without a halt, at a speed by both neighbours.
/// smooth: from rest to rest. linear: at constant speed. hold: a jump at the next.
enum class Easing { through, smooth, linear, hold };

/// The view direction relative to the line's, and the offset from the line.
struct LookAround {
    double yawDegrees = 0, pitchDegrees = 0; // to the right; up
    glm::dvec2 offsetMm{0};                  // right, up; kept within the wall
    bool operator==(const LookAround&) const = default;
};

/// Settings at a moment. Others are interpolated from neighbouring keyframes, or are the scene's.
struct Keyframe {
    std::optional<double> timeS;   // from the film's beginning ...
    std::optional<double> placeMm; // ... or along the route, from its first point: one of both
    Easing easing = Easing::through;
    std::optional<Camera> camera;   // not where a line is flown
    std::optional<LookAround> look; // only where a line is flown
    std::optional<TransferChoice> transferFunction;
    std::optional<Lighting> lighting;
    std::optional<Cuts> cuts;
};

/// Parameters of a flight along the lines.
struct Flight {
    std::vector<std::size_t> route = {0}; // numbers of lines, each a child of the one before
    bool backwards = false;               // from the route's end to its beginning
    double fromMm = 0;                    // along the route, from its first point
    std::optional<double> toMm;           // none: to its end
    double speedMmPerS = 20;
    double viewAngle = 90;   // full vertical angle, degrees
    double lookAheadMm = 15; // distance to the point on the line that the camera looks at
    double clearanceMm = 1;  // least distance to the wall, where the lumen is wide enough
    bool operator==(const Flight&) const = default;
};

struct Path {
    static constexpr int kVersion = 1;
    std::optional<PathVolume> volume;
    std::optional<Lumen> lumen;
    std::vector<CentreLine> lines;
    std::vector<Keyframe> keyframes; // in order of time or place
    std::optional<Flight> flight;    // none: the keyframes' cameras
    double framesPerSecond = 25;

    static constexpr std::size_t kMostLines = 10000, kMostPoints = 1000000, kMostKeyframes = 10000;
    static constexpr double kMostViewAngle = 170;
};

/// A point of the route as one line: each line up to where the next one leaves it. Points are those of the
/// lines; spacing differs where lines meet.
struct RoutePoint {
    glm::dvec3 at{0};
    double radiusMm = 0, alongMm = 0; // from the route's first point
};
std::vector<RoutePoint> routeOf(const std::vector<CentreLine>& lines, const std::vector<std::size_t>& route);

/// The path with nothing but its volume, its flight and the lines of that, without their names: of the same
/// curve to the bit. The path has a flight.
Path flightAlone(const Path& path);

/// Throws InputError naming where for an invalid path (docs/path.schema.json). Points must have the stated
/// even spacing, parents must exist, and branches begin on them. Keyframes must be in order and not empty. A
/// route may leave a line only at a branch, and a flight has lines.
void checkPath(const Path& path, const std::string& where);

/// Throws InputError naming the file and the JSON path for: no JSON, wrong version, unknown key, wrong type,
/// numbers out of range or not finite, counts that do not agree. Throws as checkPath() does, too.
Path loadPath(const std::filesystem::path& file);
Path parsePath(const std::string& text, const std::string& where);
/// As JSON text that parsePath() reads back to the same path; ASCII.
std::string pathJson(const Path& path);

template <> const NameTable<Easing>& namesOf<Easing>();

/// Total length of lines, and their least and largest distance to the wall, bridges apart.
struct LinesExtent {
    double lengthMm = 0, narrowestMm = 0, widestMm = 0;
};
LinesExtent extentOf(const std::vector<CentreLine>& lines);

/// "a line of 120.4 mm, 3.1 to 8 mm from the wall", "21 branches of ...".
std::string linesText(const std::vector<CentreLine>& lines);

/// The reason why lines of a lumen may lie outside of it, and from where on. Empty if there is none.
std::string doubtText(const Lumen& lumen);

} // namespace tessera
