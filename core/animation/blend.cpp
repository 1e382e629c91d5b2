// core/animation/blend.cpp: see blend.h.
#include "core/animation/blend.h"

#include "core/base/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <set>

namespace tessera {
namespace {

template <typename T> T mixed(const T& a, const T& b, double share) {
    return a + share * (b - a);
}

/// The limits of a function at a value, from below and from above; with N components.
template <std::size_t N> struct Limits { std::array<double, N> below, from; };
template <std::size_t N> struct Knot {
    double value;
    std::array<double, N> numbers;
};

template <std::size_t N> Limits<N> limitsAt(const std::vector<Knot<N>>& knots, double value) {
    const auto on = [&](std::size_t left) { // between two knots
        const Knot<N>&a = knots[left], &b = knots[left + 1];
        std::array<double, N> out{};
        const double t = (value - a.value) / (b.value - a.value);
        for (std::size_t i = 0; i < N; ++i)
            out[i] = a.numbers[i] + t * (b.numbers[i] - a.numbers[i]);
        return out;
    };
    const auto first =
        static_cast<std::size_t>(std::lower_bound(knots.begin(), knots.end(), value,
                                                  [](const Knot<N>& k, double v) { return k.value < v; }) -
                                 knots.begin());
    auto past = first;
    while (past < knots.size() && knots[past].value == value)
        ++past;
    if (first < past)
        return {knots[first].numbers, knots[past - 1].numbers};
    if (first == 0)
        return {knots.front().numbers, knots.front().numbers};
    if (first == knots.size())
        return {knots.back().numbers, knots.back().numbers};
    const auto between = on(first - 1);
    return {between, between};
}

template <std::size_t N>
std::vector<Knot<N>> blendKnots(const std::vector<Knot<N>>& a, const std::vector<Knot<N>>& b, double share) {
    std::set<double> values;
    for (const auto* knots : {&a, &b})
        for (const Knot<N>& knot : *knots)
            values.insert(knot.value);
    std::vector<Knot<N>> out;
    for (const double value : values) {
        const Limits<N> x = limitsAt(a, value), y = limitsAt(b, value);
        Knot<N> below{value, {}}, from{value, {}};
        for (std::size_t i = 0; i < N; ++i) {
            below.numbers[i] = mixed(x.below[i], y.below[i], share);
            from.numbers[i] = mixed(x.from[i], y.from[i], share);
        }
        if (below.numbers != from.numbers)
            out.push_back(below);
        out.push_back(from);
    }
    return out;
}

std::vector<Knot<1>> opacityKnots(const TransferFunction& f) {
    std::vector<Knot<1>> knots;
    for (const OpacityPoint& p : f.opacityPoints())
        knots.push_back({p.value, {p.opacity}});
    if (knots.empty())
        knots.push_back({0, {0}});
    return knots;
}
std::vector<Knot<3>> colourKnots(const TransferFunction& f) {
    std::vector<Knot<3>> knots;
    for (const ColourPoint& p : f.colourPoints())
        knots.push_back({p.value, {p.colour.r, p.colour.g, p.colour.b}});
    if (knots.empty())
        knots.push_back({0, {1, 1, 1}});
    return knots;
}

/// Of another kind: as it is.
Phase blend(Phase phase, const Phase& to, double share) {
    if (phase.kind == to.kind)
        for (double Phase::*number : {&Phase::g, &Phase::backG, &Phase::backShare})
            phase.*number = mixed(phase.*number, to.*number, share);
    return phase;
}

SurfaceFinish blend(SurfaceFinish finish, const SurfaceFinish& to, double share) {
    for (double SurfaceFinish::*number : {&SurfaceFinish::mirrored, &SurfaceFinish::roughness,
                                          &SurfaceFinish::translucent, &SurfaceFinish::translucentPower})
        finish.*number = mixed(finish.*number, to.*number, share);
    return finish;
}

/// What one of both lacks stays.
Tissue blend(Tissue tissue, const Tissue& to, double share) {
    if (tissue.phase && to.phase)
        tissue.phase = blend(*tissue.phase, *to.phase, share);
    if (tissue.finish && to.finish)
        tissue.finish = blend(*tissue.finish, *to.finish, share);
    return tissue;
}

Material blend(const Material& a, const Material& b, double share) {
    Material m = a;
    m.ambient = mixed(a.ambient, b.ambient, share);
    m.diffuse = mixed(a.diffuse, b.diffuse, share);
    m.specular = mixed(a.specular, b.specular, share);
    m.specularPower = static_cast<int>(std::lround(
        mixed(static_cast<double>(a.specularPower), static_cast<double>(b.specularPower), share)));
    m.emission = mixed(a.emission, b.emission, share);
    return m;
}

template <typename List, typename Same> bool alike(const List& a, const List& b, const Same& same) {
    return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), same);
}

/// Interpolates between two directions, whose lengths count too.
glm::dvec3 turned(const glm::dvec3& a, const glm::dvec3& b, double share) {
    const glm::dvec3 between = mixed(a, b, share);
    return glm::length(between) > 1e-6 * (glm::length(a) + glm::length(b)) ? between : a;
}

glm::dvec4 quaternionOf(const Camera& camera) {
    const glm::dmat3 m = patientFromCamera(camera); // columns: right, up, towards
    // Shepperd's method: from the largest of the four
    const std::array<double, 4> squares = {1 + m[0][0] + m[1][1] + m[2][2], 1 + m[0][0] - m[1][1] - m[2][2],
                                           1 - m[0][0] + m[1][1] - m[2][2], 1 - m[0][0] - m[1][1] + m[2][2]};
    const auto most = std::max_element(squares.begin(), squares.end()) - squares.begin();
    const double s = 2 * std::sqrt(squares[static_cast<std::size_t>(most)]);
    switch (most) {
    case 0:
        return {(m[1][2] - m[2][1]) / s, (m[2][0] - m[0][2]) / s, (m[0][1] - m[1][0]) / s, s / 4};
    case 1:
        return {s / 4, (m[1][0] + m[0][1]) / s, (m[2][0] + m[0][2]) / s, (m[1][2] - m[2][1]) / s};
    case 2:
        return {(m[1][0] + m[0][1]) / s, s / 4, (m[2][1] + m[1][2]) / s, (m[2][0] - m[0][2]) / s};
    default:
        return {(m[2][0] + m[0][2]) / s, (m[2][1] + m[1][2]) / s, s / 4, (m[0][1] - m[1][0]) / s};
    }
}
/// The axes up and towards of a unit quaternion (x, y, z, w).
void axesOf(const glm::dvec4& q, glm::dvec3& up, glm::dvec3& towards) {
    up = {2 * (q.x * q.y - q.w * q.z), 1 - 2 * (q.x * q.x + q.z * q.z), 2 * (q.y * q.z + q.w * q.x)};
    towards = {2 * (q.x * q.z + q.w * q.y), 2 * (q.y * q.z - q.w * q.x), 1 - 2 * (q.x * q.x + q.y * q.y)};
}

double distanceOf(const Camera& camera) {
    return glm::length(camera.position - camera.focalPoint);
}

std::vector<std::vector<double>> numbersOf(const std::vector<Camera>& cameras) {
    std::vector<std::vector<double>> out;
    glm::dvec4 before(0);
    for (const Camera& camera : cameras) {
        glm::dvec4 q = quaternionOf(camera);
        if (glm::dot(q, before) < 0)
            q = -q; // the shorter way
        before = q;
        out.push_back({q.x, q.y, q.z, q.w, camera.focalPoint.x, camera.focalPoint.y, camera.focalPoint.z,
                       std::log(distanceOf(camera)), camera.viewAngle, std::log(camera.parallelScale)});
    }
    return out;
}

/// The distance between two cameras, mm: a rotation counts as the movement of the focal point on the picture.
double wayBetween(const Camera& a, const Camera& b) {
    const glm::dvec3 da = glm::normalize(a.focalPoint - a.position),
                     db = glm::normalize(b.focalPoint - b.position);
    const glm::dvec3 ua = patientFromCamera(a)[1], ub = patientFromCamera(b)[1];
    const double reach = 0.5 * (distanceOf(a) + distanceOf(b));
    const double turn = reach * std::max(glm::length(db - da), glm::length(ub - ua));
    const double zoom = reach * (std::abs(std::log(b.parallelScale / a.parallelScale)) +
                                 0.02 * std::abs(b.viewAngle - a.viewAngle));
    return std::hypot(glm::length(b.position - a.position), turn, zoom);
}

std::vector<double> placesOf(const std::vector<Camera>& cameras) {
    std::vector<double> places = {0};
    for (std::size_t k = 1; k < cameras.size(); ++k) // equal cameras still get distinct places
        places.push_back(places.back() +
                         std::max(wayBetween(cameras[k - 1], cameras[k]), 1e-6 * distanceOf(cameras[k])));
    return places;
}

/// Point by point; no points are points of 1. With different counts or units the first function is used.
GradientOpacity blend(const GradientOpacity& a, const GradientOpacity& b, double share) {
    if (a.isOne() && b.isOne())
        return a;
    const auto onesLike = [](std::vector<GradientPoint> points) {
        for (GradientPoint& p : points)
            p.factor = 1;
        return points;
    };
    std::vector<GradientPoint> points = a.isOne() ? onesLike(b.points()) : a.points();
    const std::vector<GradientPoint> to = b.isOne() ? onesLike(a.points()) : b.points();
    if (!a.isOne() && !b.isOne() && (points.size() != to.size() || a.per() != b.per()))
        return a;
    for (std::size_t i = 0; i < points.size(); ++i)
        points[i] = {points[i].length + share * (to[i].length - points[i].length),
                     points[i].factor + share * (to[i].factor - points[i].factor)};
    return GradientOpacity::fromPoints(std::move(points), a.isOne() ? b.per() : a.per(), "keyframes");
}

} // namespace

TransferFunction blend(const TransferFunction& a, const TransferFunction& b, double share) {
    if (share <= 0)
        return a;
    if (share >= 1)
        return b;
    if (a.referenceLengthMm() != b.referenceLengthMm())
        throw InputError(
            "keyframes: expected transfer functions with the same scalarOpacityUnitDistance, found " +
            std::to_string(a.referenceLengthMm()) + " and " + std::to_string(b.referenceLengthMm()) + " mm");
    std::vector<OpacityPoint> opacity;
    for (const Knot<1>& knot : blendKnots(opacityKnots(a), opacityKnots(b), share))
        opacity.push_back({knot.value, knot.numbers[0]});
    std::vector<ColourPoint> colour;
    for (const Knot<3>& knot : blendKnots(colourKnots(a), colourKnots(b), share))
        colour.push_back({knot.value, {knot.numbers[0], knot.numbers[1], knot.numbers[2]}});
    TransferFunction out = TransferFunction::fromOpacity(std::move(opacity), std::move(colour),
                                                         a.referenceLengthMm(), "keyframes");
    std::vector<Material> materials = a.materials();
    if (alike(materials, b.materials(),
              [](const Material& x, const Material& y) { return x.from == y.from && x.to == y.to; }))
        for (std::size_t i = 0; i < materials.size(); ++i)
            materials[i] = blend(materials[i], b.materials()[i], share);
    out.setMaterials(std::move(materials), "keyframes");
    std::vector<Tissue> tissues = a.tissues();
    if (alike(tissues, b.tissues(),
              [](const Tissue& x, const Tissue& y) { return x.from == y.from && x.to == y.to; }))
        for (std::size_t i = 0; i < tissues.size(); ++i)
            tissues[i] = blend(tissues[i], b.tissues()[i], share);
    out.setTissues(std::move(tissues), "keyframes");
    out.setGradientOpacity(blend(a.gradientOpacity(), b.gradientOpacity(), share));
    return out;
}

Lighting blend(const Lighting& a, const Lighting& b, double share) {
    if (share <= 0 || a == b)
        return a;
    if (share >= 1)
        return b;
    Lighting out = a;
    if (alike(a.lights, b.lights, [](const Light& x, const Light& y) {
            return x.kind == y.kind && x.frame == y.frame && x.shadow == y.shadow;
        }))
        for (std::size_t i = 0; i < out.lights.size(); ++i) {
            Light& light = out.lights[i];
            const Light& to = b.lights[i];
            light.direction = turned(light.direction, to.direction, share);
            light.position = mixed(light.position, to.position, share);
            light.attenuation = mixed(light.attenuation, to.attenuation, share);
            light.intensity = mixed(light.intensity, to.intensity, share);
            light.colour = mixed(light.colour, to.colour, share);
            light.softness = mixed(light.softness, to.softness, share);
            if (a.scatterBy == b.scatterBy)
                light.scatter = mixed(light.scatter, to.scatter, share);
        }
    if (a.shadowMap.kind == b.shadowMap.kind && a.shadowMap.filter == b.shadowMap.filter)
        out.shadowMap.threshold = mixed(a.shadowMap.threshold, b.shadowMap.threshold, share);
    out.scatterRadiusMm = mixed(a.scatterRadiusMm, b.scatterRadiusMm, share);
    out.lightMap.g = mixed(a.lightMap.g, b.lightMap.g, share);
    if (a.occlusion && b.occlusion && a.occlusion->method == b.occlusion->method &&
        a.occlusion->rays == b.occlusion->rays) {
        const Occlusion& to = *b.occlusion;
        Occlusion& o = *out.occlusion;
        if (o.method != OcclusionMethod::histogram) // whose ball is that of what is kept
            o.radiusMm = mixed(o.radiusMm, to.radiusMm, share);
        o.offsetMm = mixed(o.offsetMm, to.offsetMm, share);
        o.bias = mixed(o.bias, to.bias, share);
        o.gamma = mixed(o.gamma, to.gamma, share);
        o.emission = mixed(o.emission, to.emission, share);
        o.bleeding = mixed(o.bleeding, to.bleeding, share);
        if (o.weights && to.weights) {
            o.weights->towards = turned(o.weights->towards, to.weights->towards, share);
            o.weights->strength = mixed(o.weights->strength, to.weights->strength, share);
        }
    }
    if (a.surfaceOcclusion && b.surfaceOcclusion && a.surfaceOcclusion->rays == b.surfaceOcclusion->rays)
        out.surfaceOcclusion->radiusMm =
            mixed(a.surfaceOcclusion->radiusMm, b.surfaceOcclusion->radiusMm, share);
    if (a.transport && b.transport)
        out.transport->phase = blend(a.transport->phase, b.transport->phase, share);
    if (a.transport && b.transport && a.transport->surface && b.transport->surface) {
        const SurfaceScattering& to = *b.transport->surface;
        SurfaceScattering& surface = *out.transport->surface;
        surface.gradient.low = mixed(surface.gradient.low, to.gradient.low, share);
        surface.gradient.high = mixed(surface.gradient.high, to.gradient.high, share);
        surface.finish = blend(surface.finish, to.finish, share);
    }
    if (a.environment && b.environment && a.environment->sky == b.environment->sky &&
        a.environment->file == b.environment->file && a.environment->frame == b.environment->frame) {
        const Environment& to = *b.environment;
        Environment& e = *out.environment;
        e.intensity = mixed(e.intensity, to.intensity, share);
        e.colour = mixed(e.colour, to.colour, share);
        e.below = mixed(e.below, to.below, share);
        e.up = turned(e.up, to.up, share);
        e.rotation = mixed(e.rotation, to.rotation, share);
    }
    return out;
}

Cuts blend(const Cuts& a, const Cuts& b, double share) {
    if (share <= 0 || a == b)
        return a;
    if (share >= 1)
        return b;
    Cuts out = a;
    if (alike(a.boxes, b.boxes,
              [](const CropBox& x, const CropBox& y) { return x.space == y.space && x.keep == y.keep; }))
        for (std::size_t i = 0; i < out.boxes.size(); ++i) {
            out.boxes[i].low = mixed(a.boxes[i].low, b.boxes[i].low, share);
            out.boxes[i].high = mixed(a.boxes[i].high, b.boxes[i].high, share);
        }
    if (alike(a.planes, b.planes, [](const CutPlane& x, const CutPlane& y) { return x.keep == y.keep; }))
        for (std::size_t i = 0; i < out.planes.size(); ++i) {
            out.planes[i].point = mixed(a.planes[i].point, b.planes[i].point, share);
            out.planes[i].normal =
                turned(glm::normalize(a.planes[i].normal), glm::normalize(b.planes[i].normal), share);
        }
    return out;
}

Pace::Pace(std::vector<double> times, std::vector<double> values, const std::vector<Easing>& easings)
    : times_(std::move(times)), values_(std::move(values)) {
    const std::size_t segments = times_.size() - 1;
    std::vector<double> speed(segments);
    for (std::size_t k = 0; k < segments; ++k) {
        speed[k] = (values_[k + 1] - values_[k]) / (times_[k + 1] - times_[k]);
        held_.push_back(easings[k] == Easing::hold);
    }
    const auto rests = [&](std::size_t k) {
        return easings[k] == Easing::smooth || easings[k] == Easing::hold;
    };
    const auto at = [&](std::size_t key) { // the speed at a keyframe, which both segments share
        if ((key > 0 && rests(key - 1)) || (key < segments && rests(key)))
            return 0.0;
        if (key == 0 || key == segments)
            return speed[key == 0 ? 0 : segments - 1];
        for (const std::size_t k : {key - 1, key})
            if (easings[k] == Easing::linear) // at most the speed at which the other segment stays monotone
                return std::min(speed[k], 3 * speed[k == key ? key - 1 : key]);
        // Fritsch and Butland's harmonic mean: monotone
        const double a = speed[key - 1], b = speed[key];
        if (!(a > 0 && b > 0))
            return 0.0;
        const double ta = times_[key] - times_[key - 1], tb = times_[key + 1] - times_[key];
        return 3 * (ta + tb) / ((ta + 2 * tb) / a + (2 * ta + tb) / b);
    };
    for (std::size_t k = 0; k < segments; ++k) {
        const bool even = easings[k] == Easing::linear;
        leaving_.push_back(even ? speed[k] : at(k));
        arriving_.push_back(even ? speed[k] : at(k + 1));
    }
}

Pace::Moment Pace::at(double time) const {
    if (time <= times_.front())
        return {0, values_.front()};
    if (time >= times_.back())
        return {times_.size() - 1, values_.back()};
    const auto k =
        static_cast<std::size_t>(std::upper_bound(times_.begin(), times_.end(), time) - times_.begin()) - 1;
    if (held_[k])
        return {k, values_[k]};
    const double h = times_[k + 1] - times_[k], t = (time - times_[k]) / h, t2 = t * t, t3 = t2 * t;
    const double value = (2 * t3 - 3 * t2 + 1) * values_[k] + (t3 - 2 * t2 + t) * h * leaving_[k] +
                         (3 * t2 - 2 * t3) * values_[k + 1] + (t3 - t2) * h * arriving_[k];
    return {k, std::clamp(value, values_[k], values_[k + 1])};
}

Spline::Spline(std::vector<double> places, std::vector<std::vector<double>> values)
    : places_(std::move(places)), values_(std::move(values)) {
    const std::size_t n = places_.size(), numbers = values_.front().size();
    second_.assign(n, std::vector<double>(numbers, 0));
    // Thomas' algorithm for the natural spline's second derivatives
    std::vector<double> ratio(n, 0);
    for (std::size_t i = 1; i + 1 < n; ++i) {
        const double a = places_[i] - places_[i - 1], b = places_[i + 1] - places_[i];
        const double pivot = 2 * (a + b) - a * ratio[i - 1];
        ratio[i] = b / pivot;
        for (std::size_t c = 0; c < numbers; ++c) {
            const double right =
                6 * ((values_[i + 1][c] - values_[i][c]) / b - (values_[i][c] - values_[i - 1][c]) / a);
            second_[i][c] = (right - a * second_[i - 1][c]) / pivot;
        }
    }
    for (std::size_t i = n; i-- > 2;)
        for (std::size_t c = 0; c < numbers; ++c)
            second_[i - 1][c] -= ratio[i - 1] * second_[i][c];
}

std::vector<double> Spline::at(double given) const {
    if (places_.size() == 1)
        return values_.front();
    const double place = std::clamp(given, places_.front(), places_.back());
    const auto i = static_cast<std::size_t>(std::upper_bound(places_.begin() + 1, places_.end() - 1, place) -
                                            places_.begin()) -
                   1;
    const double h = places_[i + 1] - places_[i], b = (place - places_[i]) / h, a = 1 - b;
    std::vector<double> out;
    for (std::size_t c = 0; c < values_[i].size(); ++c)
        out.push_back(a * values_[i][c] + b * values_[i + 1][c] +
                      ((a * a * a - a) * second_[i][c] + (b * b * b - b) * second_[i + 1][c]) * h * h / 6);
    return out;
}

CameraCurve::CameraCurve(const std::vector<double>& times, const std::vector<Camera>& cameras,
                         const std::vector<Easing>& easings, const std::string& where)
    : places_(placesOf(cameras)), cameras_(cameras), spline_(places_, numbersOf(cameras)),
      pace_({0}, {0}, {}) {
    for (const Camera& camera : cameras_)
        if (camera.projection != cameras_.front().projection)
            throw badFile(where, "cameras of one projection in all keyframes", "both");
    // The camera's movement along each segment, for constant speed within it.
    constexpr int kParts = 64;
    std::vector<double> way = {0};
    for (std::size_t k = 0; k + 1 < cameras_.size(); ++k) {
        std::vector<double> moved = {0};
        Camera before = between(places_[k]);
        for (int i = 1; i <= kParts; ++i) {
            const Camera now = between(places_[k] + (places_[k + 1] - places_[k]) * i / kParts);
            moved.push_back(moved.back() + wayBetween(before, now));
            before = now;
        }
        way.push_back(way.back() + moved.back());
        wayMm_.push_back(std::move(moved));
    }
    pace_ = Pace(times, std::move(way), easings);
}

Camera CameraCurve::between(double place) const {
    const std::vector<double> n = spline_.at(place);
    Camera camera = cameras_.front();
    glm::dvec3 towards(0);
    axesOf(glm::normalize(glm::dvec4(n[0], n[1], n[2], n[3])), camera.viewUp, towards);
    camera.focalPoint = {n[4], n[5], n[6]};
    camera.position = camera.focalPoint + std::exp(n[7]) * towards;
    camera.viewAngle = std::clamp(n[8], 0.01, 179.0);
    camera.parallelScale = std::exp(n[9]);
    return camera;
}

Camera CameraCurve::at(double time) const {
    const Pace::Moment moment = pace_.at(time);
    if (moment.key + 1 >= cameras_.size())
        return cameras_.back();
    double begins = 0;
    for (std::size_t k = 0; k < moment.key; ++k)
        begins += wayMm_[k].back();
    const double moved = moment.value - begins;
    if (!(moved > 0))
        return cameras_[moment.key]; // exactly the keyframe's camera
    const std::vector<double>& way = wayMm_[moment.key];
    const auto above =
        std::clamp<std::ptrdiff_t>(std::upper_bound(way.begin(), way.end(), moved) - way.begin(), 1,
                                   static_cast<std::ptrdiff_t>(way.size()) - 1);
    const double low = way[static_cast<std::size_t>(above - 1)], high = way[static_cast<std::size_t>(above)];
    const double part = (static_cast<double>(above - 1) + (high > low ? (moved - low) / (high - low) : 0)) /
                        static_cast<double>(way.size() - 1);
    return between(mixed(places_[moment.key], places_[moment.key + 1], part));
}

} // namespace tessera
