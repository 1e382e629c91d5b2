// core/animation/path.h: paths through a volume, as one value and as one JSON file (docs/path.schema.json):
// centre-lines of hollow organs, keyframes, and the parameters of a flight. core/animation/flight.h makes the
// curve of them.
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

/// One branch of a hollow organ's centre-line: places evenly along it, in patient space.
struct CentreLine {
    std::string name;               // for people; may be empty
    std::vector<glm::dvec3> points; // mm, LPS; at least kFewestPoints
    std::vector<double> radiusMm;   // distance to the wall, one for every point, 0 or more
    double spacingMm = 0;           // from a point to the next along the line; straight ones are not longer
    std::optional<std::size_t> parent = {}; // the line that it leaves, an earlier one
    double leavesAtMm = 0;                  // where: along the parent, from its first point

    static constexpr std::size_t kFewestPoints = 2;
    double lengthMm() const { return spacingMm * static_cast<double>(points.size() - 1); }
    bool operator==(const CentreLine&) const = default;
};

/// What was taken to be lumen when the lines were made: values on one side of a threshold.
struct Lumen {
    enum class Side { below, above };
    double threshold = 0; // physical units
    Side side = Side::below;
    double noise = 0;   // standard deviation of the noise that was taken off the values first; 0: none was
    bool leaks = false; // into what is beyond its wall, as whoever made the lines was told
    /// leaks: where the first line leaves what is lumen at a threshold that does not leak, along it; none: it
    /// does not, or nobody knows.
    std::optional<double> leavesAtMm = {};
    bool unsure = false; // the threshold hardly differs from the noise of values in the lumen
    /// Where the volume's own values, noise and all, show the wall; none: at the threshold.
    std::optional<double> surface = {};
    /// Thin branches of a tree were followed to this value, beyond the threshold; none: there were none.
    std::optional<double> branchesTo = {};
    /// How far the values around a thin branch are beyond its own, at least: a wall, physical units.
    std::optional<double> branchWall = {};
    double shownAt() const { return surface.value_or(threshold); }
    bool operator==(const Lumen&) const = default;
};

/// Which volume the lines were made in.
struct PathVolume {
    std::string contentHash; // StoreReader::contentHash()
    glm::ivec3 extentVoxels{0};
    bool operator==(const PathVolume&) const = default;
};

/// The transition from one keyframe to the next. through: without a halt, at the speed that both neighbours
/// ask for. smooth: beginning and ending at rest. linear: at one speed. hold: not before the next.
enum class Easing { through, smooth, linear, hold };

/// Where one looks to from the line, against its direction, and how far beside it one is.
struct LookAround {
    double yawDegrees = 0, pitchDegrees = 0; // to the right; up
    glm::dvec2 offsetMm{0};                  // right, up; held within the wall
    bool operator==(const LookAround&) const = default;
};

/// What is said at a moment; of the rest the neighbours decide, or the scene.
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

/// How the lines are flown.
struct Flight {
    std::vector<std::size_t> route = {0}; // lines, each a child of the one before: where branches are taken
    bool backwards = false;               // from the route's end to its beginning
    double fromMm = 0;                    // along the route, from its first point
    std::optional<double> toMm;           // none: to its end
    double speedMmPerS = 20;
    double viewAngle = 90;   // full vertical angle, degrees
    double lookAheadMm = 15; // the place on the line that one looks at
    double clearanceMm = 1;  // from the wall, where the lumen is wide enough
    bool operator==(const Flight&) const = default;
};

struct Path {
    static constexpr int kVersion = 1;
    std::optional<PathVolume> volume;
    std::optional<Lumen> lumen;
    std::vector<CentreLine> lines;
    std::vector<Keyframe> keyframes; // in the order of their moments
    std::optional<Flight> flight;    // none: the keyframes' cameras
    double framesPerSecond = 25;

    static constexpr std::size_t kMostLines = 10000, kMostPoints = 1000000, kMostKeyframes = 10000;
    static constexpr double kMostViewAngle = 170;
};

/// What is along the route as one line: lines up to where the next one leaves, one after another. Points are
/// those of the lines; spacing differs where they meet.
struct RoutePoint {
    glm::dvec3 at{0};
    double radiusMm = 0, alongMm = 0; // from the route's first point
};
std::vector<RoutePoint> routeOf(const std::vector<CentreLine>& lines, const std::vector<std::size_t>& route);

/// Throws InputError naming where for what no file may say (docs/path.schema.json). Points must be evenly
/// spaced as they claim, parents must exist, and branches begin on them. Keyframes must be in order and say
/// something. A route may leave a line only where a branch is, and a flight has lines.
void checkPath(const Path& path, const std::string& where);

/// Throws InputError naming the file and the JSON path for: no JSON, wrong version, unknown key, wrong type,
/// numbers out of range or not finite, counts that do not agree. Throws also what checkPath() throws.
Path loadPath(const std::filesystem::path& file);
Path parsePath(const std::string& text, const std::string& where);
/// As JSON text that parsePath() reads back to the same path; ASCII.
std::string pathJson(const Path& path);

template <> const NameTable<Easing>& namesOf<Easing>();

} // namespace tessera
