// core/animation/flight.cpp: see flight.h.
#include "core/animation/flight.h"

#include "core/base/error.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

namespace tessera {
namespace {

constexpr int kNodes = 4; // a span of the spline, where arc length and frame are known

/// The corners of the route, where lines meet, are rounded within the lumen, over about its radius.
void roundCorners(std::vector<RoutePoint>& points, const std::vector<double>& corners) {
    for (const double corner : corners) {
        const auto at = std::lower_bound(points.begin(), points.end(), corner,
                                         [](const RoutePoint& p, double mm) { return p.alongMm < mm; });
        if (at == points.begin() || at == points.end())
            continue;
        const double reach = at->radiusMm, spacing = at->alongMm - (at - 1)->alongMm;
        std::size_t first = 1, last = points.size() - 1; // the range that moves; the ends stay
        while (first < points.size() && points[first].alongMm < corner - 2 * reach)
            ++first;
        while (last > first && points[last - 1].alongMm > corner + 2 * reach)
            --last;
        // [1 2 1]/4 n times is a Gaussian of sqrt(n/2) spacings' deviation
        const int passes =
            static_cast<int>(std::min(2 * (0.6 * reach / spacing) * (0.6 * reach / spacing), 4000.0));
        const std::vector<RoutePoint> as = points;
        for (int pass = 0; pass < passes; ++pass) {
            std::vector<glm::dvec3> smooth;
            for (std::size_t i = first; i < last; ++i) {
                const glm::dvec3 p = 0.25 * (points[i - 1].at + 2.0 * points[i].at + points[i + 1].at);
                const glm::dvec3 moved = p - as[i].at;
                const double far = glm::length(moved), most = 0.5 * as[i].radiusMm;
                smooth.push_back(far > most ? as[i].at + moved * (most / far) : p);
            }
            for (std::size_t i = first; i < last; ++i)
                points[i].at = smooth[i - first];
        }
        for (std::size_t i = first; i < last; ++i)
            points[i].radiusMm = std::max(0.0, as[i].radiusMm - glm::length(points[i].at - as[i].at));
    }
}

/// The part of the route from one place to another, with a point at each end.
std::vector<RoutePoint> partOf(const std::vector<RoutePoint>& route, double from, double to) {
    const auto between = [&](double mm) {
        std::size_t i = 1;
        while (i + 1 < route.size() && route[i].alongMm < mm)
            ++i;
        const RoutePoint &a = route[i - 1], &b = route[i];
        const double t = std::clamp((mm - a.alongMm) / (b.alongMm - a.alongMm), 0.0, 1.0);
        return RoutePoint{a.at + t * (b.at - a.at), a.radiusMm + t * (b.radiusMm - a.radiusMm), mm};
    };
    std::vector<RoutePoint> part = {between(from)};
    for (const RoutePoint& p : route)
        if (p.alongMm > from && p.alongMm < to)
            part.push_back(p);
    part.push_back(between(to));
    // An end that all but coincides with its neighbour would make the curve turn on the spot.
    const double spacing =
        (route.back().alongMm - route.front().alongMm) / static_cast<double>(route.size() - 1);
    if (part.size() > 2 && part[1].alongMm - part[0].alongMm < 0.5 * spacing)
        part.erase(part.begin() + 1);
    if (part.size() > 2 && part.back().alongMm - part[part.size() - 2].alongMm < 0.5 * spacing)
        part.erase(part.end() - 2);
    return part;
}

/// A direction at right angles to it, towards the head or the front where possible.
glm::dvec3 firstUp(const glm::dvec3& direction) {
    const glm::dvec3 wished = std::abs(direction.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(0, -1, 0);
    return glm::normalize(wished - glm::dot(wished, direction) * direction);
}

} // namespace

FlightCurve::FlightCurve(const std::vector<CentreLine>& lines, const Flight& flight)
    : lookAheadMm_(flight.lookAheadMm) {
    std::vector<RoutePoint> route = routeOf(lines, flight.route);
    TESSERA_CHECK(route.size() >= 2);
    std::vector<double> corners;
    double before = 0;
    for (std::size_t k = 1; k < flight.route.size(); ++k) {
        // along the route, from its beginning: each line is entered at its first point
        before += lines[flight.route[k]].leavesAtMm;
        corners.push_back(before);
    }
    roundCorners(route, corners);
    route = partOf(route, flight.fromMm,
                   std::min(flight.toMm.value_or(route.back().alongMm), route.back().alongMm));
    if (flight.backwards)
        std::reverse(route.begin(), route.end());
    control_.push_back({2.0 * route[0].at - route[1].at, route[0].radiusMm, 0});
    control_.insert(control_.end(), route.begin(), route.end());
    control_.push_back({2.0 * route.back().at - route[route.size() - 2].at, route.back().radiusMm, 0});

    const std::size_t spans = route.size() - 1;
    nodes_.resize(spans * kNodes + 1);
    const auto parameterOf = [](std::size_t node) { return static_cast<double>(node) / kNodes; };
    for (std::size_t n = 0; n < nodes_.size(); ++n) {
        nodes_[n].freeMm = freeAt(parameterOf(n));
        if (n == 0)
            continue;
        // Simpson's rule on the speed
        const double a = parameterOf(n - 1), b = parameterOf(n);
        const double speeds =
            glm::length(point(a, 1)) + 4 * glm::length(point(0.5 * (a + b), 1)) + glm::length(point(b, 1));
        nodes_[n].arcMm = nodes_[n - 1].arcMm + (b - a) / 6 * speeds;
    }
    lengthMm_ = nodes_.back().arcMm;
    // The minimum distance within a radius along the route, then its mean over the same radius. It never
    // exceeds the true distance, and changes slowly, so that a camera kept off by it does not jitter.
    constexpr double kReachMm = 4;
    const auto window = [&](const std::vector<double>& values, bool mean) {
        std::vector<double> out(values.size());
        std::size_t low = 0, high = 0;
        for (std::size_t n = 0; n < values.size(); ++n) {
            while (nodes_[low].arcMm < nodes_[n].arcMm - kReachMm)
                ++low;
            while (high < values.size() && nodes_[high].arcMm <= nodes_[n].arcMm + kReachMm)
                ++high;
            double sum = 0, least = values[n];
            for (std::size_t k = low; k < high; ++k) {
                sum += values[k];
                least = std::min(least, values[k]);
            }
            out[n] = mean ? sum / static_cast<double>(high - low) : least;
        }
        return out;
    };
    std::vector<double> free;
    for (const Node& node : nodes_)
        free.push_back(node.freeMm);
    free = window(window(free, false), true);
    for (std::size_t n = 0; n < nodes_.size(); ++n)
        nodes_[n].freeMm = std::max(0.0, free[n]);
    nodes_[0].up = firstUp(direction(0));
    for (std::size_t n = 1; n < nodes_.size(); ++n)
        nodes_[n].up = carried(nodes_[n - 1].up, nodes_[n - 1].arcMm, nodes_[n].arcMm);
}

/// The uniform cubic B-spline: u in spans, 0 at the route's first point.
glm::dvec3 FlightCurve::point(double u, int derivative) const {
    const std::size_t spans = control_.size() - 3;
    const auto i = std::min(static_cast<std::size_t>(std::max(u, 0.0)), spans - 1);
    const double t = u - static_cast<double>(i), s = 1 - t;
    const glm::dvec3 &a = control_[i].at, &b = control_[i + 1].at, &c = control_[i + 2].at,
                     &d = control_[i + 3].at;
    if (derivative == 1)
        return 0.5 * (-s * s * a + (3 * t * t - 4 * t) * b + (-3 * t * t + 2 * t + 1) * c + t * t * d);
    return (s * s * s * a + (3 * t * t * t - 6 * t * t + 4) * b + (3 * s * s * s - 6 * s * s + 4) * c +
            t * t * t * d) /
           6.0;
}

/// The wall is at least as far as its distance from a point minus the distance to that point.
double FlightCurve::freeAt(double u) const {
    const std::size_t spans = control_.size() - 3;
    const auto i = std::min(static_cast<std::size_t>(std::max(u, 0.0)), spans - 1);
    const glm::dvec3 at = point(u);
    double free = 0;
    for (std::size_t k = i; k < i + 4; ++k)
        if (k > 0 && k + 1 < control_.size())
            free = std::max(free, control_[k].radiusMm - glm::length(at - control_[k].at));
    return free;
}

/// From arc length to the spline's parameter: cubic between nodes, with the speeds at both.
double FlightCurve::parameter(double mm) const {
    const auto above = std::upper_bound(nodes_.begin() + 1, nodes_.end() - 1, mm,
                                        [](double value, const Node& node) { return value < node.arcMm; });
    const auto n = static_cast<std::size_t>(above - nodes_.begin());
    const double u0 = static_cast<double>(n - 1) / kNodes, u1 = static_cast<double>(n) / kNodes;
    const double s0 = nodes_[n - 1].arcMm, length = nodes_[n].arcMm - s0;
    const double t = (mm - s0) / length;
    const double m0 = length / glm::length(point(u0, 1)), m1 = length / glm::length(point(u1, 1));
    const double t2 = t * t, t3 = t2 * t;
    return (2 * t3 - 3 * t2 + 1) * u0 + (t3 - 2 * t2 + t) * m0 + (3 * t2 - 2 * t3) * u1 + (t3 - t2) * m1;
}

glm::dvec3 FlightCurve::tangent(double mm) const {
    return glm::normalize(point(parameter(std::clamp(mm, 0.0, lengthMm_)), 1));
}

glm::dvec3 FlightCurve::place(double mm) const {
    const double held = std::clamp(mm, 0.0, lengthMm_);
    const glm::dvec3 at = point(parameter(held));
    return mm == held ? at : at + (mm - held) * tangent(held);
}

glm::dvec3 FlightCurve::direction(double mm) const {
    const glm::dvec3 towards = place(mm + lookAheadMm_) - place(mm);
    const double far = glm::length(towards);
    return far > 1e-3 * lookAheadMm_ && far > 1e-9 ? towards / far : tangent(mm);
}

/// By the least rotation that takes one direction to the other.
glm::dvec3 FlightCurve::carried(const glm::dvec3& up, double from, double to) const {
    const glm::dvec3 t0 = direction(from), t1 = direction(to);
    const glm::dvec3 turned = up - glm::dot(up, t1) / (1 + glm::dot(t0, t1)) * (t0 + t1);
    return glm::normalize(turned - glm::dot(turned, t1) * t1);
}

Pose FlightCurve::at(double given) const {
    const double mm = std::clamp(given, 0.0, lengthMm_);
    const auto above = std::upper_bound(nodes_.begin() + 1, nodes_.end() - 1, mm,
                                        [](double value, const Node& node) { return value < node.arcMm; });
    const Node &a = *(above - 1), &b = *above;
    const double t = (mm - a.arcMm) / (b.arcMm - a.arcMm);
    Pose pose;
    pose.at = place(mm);
    pose.direction = direction(mm);
    pose.up = carried(a.up, a.arcMm, mm);
    pose.freeMm = std::min(a.freeMm + t * (b.freeMm - a.freeMm), std::max(0.0, freeAt(parameter(mm))));
    return pose;
}

Camera cameraOf(const Pose& pose, const LookAround& look, const Flight& flight) {
    const glm::dvec3 right = glm::cross(pose.direction, pose.up);
    const double far = glm::length(look.offsetMm), most = std::max(0.0, pose.freeMm - flight.clearanceMm);
    const glm::dvec2 offset = far > most ? look.offsetMm * (most / far) : look.offsetMm;
    const double yaw = glm::radians(look.yawDegrees), pitch = glm::radians(look.pitchDegrees);
    const glm::dvec3 level = std::cos(yaw) * pose.direction + std::sin(yaw) * right;
    const glm::dvec3 view = std::cos(pitch) * level + std::sin(pitch) * pose.up;
    Camera camera;
    camera.projection = Projection::perspective;
    camera.position = pose.at + offset.x * right + offset.y * pose.up;
    camera.focalPoint = camera.position + std::max(1.0, flight.lookAheadMm) * view;
    camera.viewUp = std::cos(pitch) * pose.up - std::sin(pitch) * level;
    camera.viewAngle = flight.viewAngle;
    return camera;
}

LookAround lookTowards(const Pose& pose, const glm::dvec3& place) {
    const glm::dvec3 way = place - pose.at, right = glm::cross(pose.direction, pose.up);
    const double ahead = glm::dot(way, pose.direction), aside = glm::dot(way, right);
    LookAround look;
    look.yawDegrees = glm::degrees(std::atan2(aside, ahead));
    look.pitchDegrees = glm::degrees(std::atan2(glm::dot(way, pose.up), std::hypot(ahead, aside)));
    return look;
}

namespace {

const glm::dvec3 kWallColour(0.72, 0.30, 0.20); // mucosa, linear

} // namespace

bool showLumenWall(const Lumen& lumen, Scene& scene) {
    if (std::none_of(scene.surfaces.begin(), scene.surfaces.end(),
                     [&](const Isosurface& surface) { return surface.value == lumen.shownAt(); })) {
        if (scene.surfaces.size() >= Scene::kMaxSurfaces)
            return false;
        scene.surfaces.push_back({lumen.shownAt(), kWallColour, 1});
    }
    scene.mode = Mode::isosurface;
    return true;
}

Path flownTheOtherWay(Path path) {
    Flight& flight = path.flight.value();
    flight.backwards = !flight.backwards;
    if (std::all_of(path.keyframes.begin(), path.keyframes.end(),
                    [](const Keyframe& key) { return key.placeMm.has_value(); }))
        std::reverse(path.keyframes.begin(), path.keyframes.end());
    return path;
}

bool showsWallByDefault(const Path& path) {
    return path.lumen && !path.lines.empty() &&
           std::none_of(path.keyframes.begin(), path.keyframes.end(),
                        [](const Keyframe& key) { return key.transferFunction.has_value(); });
}

} // namespace tessera
