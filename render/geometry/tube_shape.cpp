// render/geometry/tube_shape.cpp: see tube_shape.h.
#include "render/geometry/tube_shape.h"

#include "core/base/error.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <utility>

namespace tessera {
namespace {

constexpr std::uint32_t kOfBox = 16;    // pieces, or boxes
constexpr std::size_t kMostLevels = 16; // of boxes

/// The part of a line that is nearer to the origin than a radius.
/// @param o, d  a point of the line; its direction, not 0
bool meetRound(const glm::dvec3& o, const glm::dvec3& d, double radius, double& from, double& to) {
    const double a = glm::dot(d, d), middle = -glm::dot(o, d) / a;
    const glm::dvec3 nearest = o + middle * d;
    const double left = (radius * radius - glm::dot(nearest, nearest)) / a;
    if (!(left > 0))
        return false;
    const double half = std::sqrt(left);
    from = middle - half;
    to = middle + half;
    return true;
}

/// The part of a ray in a cylinder with flat ends.
bool meetCylinder(const ShapeRay& ray, const glm::dvec3& start, const glm::dvec3& axis, double radius,
                  double& from, double& to) {
    const double length = glm::length(axis);
    if (!(length > 0))
        return false;
    const glm::dvec3 unit = axis / length, o = ray.origin - start;
    const double along = glm::dot(ray.direction, unit), at = glm::dot(o, unit);
    const glm::dvec3 across = ray.direction - along * unit, off = o - at * unit;
    from = -std::numeric_limits<double>::max();
    to = std::numeric_limits<double>::max();
    if (glm::dot(across, across) > 1e-24 * glm::dot(ray.direction, ray.direction)) {
        if (!meetRound(off, across, radius, from, to))
            return false;
    } else if (!(glm::dot(off, off) < radius * radius)) {
        return false;
    }
    if (along != 0) {
        const double a0 = -at / along, a1 = (length - at) / along;
        from = std::max(from, std::min(a0, a1));
        to = std::min(to, std::max(a0, a1));
    } else if (at < 0 || at > length) {
        return false;
    }
    return to > from;
}

bool meetsBox(const ShapeRay& ray, const ShapeBox& box) {
    double from = -std::numeric_limits<double>::max(), to = std::numeric_limits<double>::max();
    for (int axis = 0; axis < 3; ++axis) {
        const double d = ray.direction[axis], o = ray.origin[axis];
        if (d == 0) {
            if (o < box.low[axis] || o > box.high[axis])
                return false;
            continue;
        }
        const double a = (box.low[axis] - o) / d, b = (box.high[axis] - o) / d;
        from = std::max(from, std::min(a, b));
        to = std::min(to, std::max(a, b));
    }
    return to >= from;
}

} // namespace

TubeShape::TubeShape(Tube tube, MemoryBudget& ram)
    : TubeShape(tube, {static_cast<std::uint32_t>(tube.points.size())}, ram) {}

TubeShape::TubeShape(Tube tube, const std::vector<std::uint32_t>& ends, MemoryBudget& ram)
    : tube_(std::move(tube)) {
    TESSERA_CHECK(!ends.empty() && ends.back() == tube_.points.size());
    const std::size_t points = tube_.points.size(); // at least as many as pieces
    charge_ = ram.charge(points * (sizeof(glm::dvec3) + sizeof(Piece)) +
                             (points / (kOfBox - 1) + kMostLevels) * sizeof(ShapeBox),
                         "a tube");
    pieces_.reserve(points);
    std::uint32_t begin = 0;
    for (const std::uint32_t end : ends) {
        TESSERA_CHECK(begin < end && end <= points);
        if (end - begin == 1)
            pieces_.push_back({begin, begin});
        for (; begin + 1 < end; ++begin)
            pieces_.push_back({begin, begin + 1});
        begin = end;
    }
    const auto boxesOf = [&](std::size_t parts) -> std::vector<ShapeBox>& {
        return boxes_.emplace_back((parts + kOfBox - 1) / kOfBox);
    };
    std::vector<ShapeBox>& around = boxesOf(pieces_.size());
    const double wide = tube_.radiusMm * (1 + 1e-9);
    for (std::size_t piece = 0; piece < pieces_.size(); ++piece)
        for (const std::uint32_t end : {pieces_[piece].from, pieces_[piece].to})
            for (const double side : {-wide, wide}) {
                around[piece / kOfBox].add(tube_.points[end] + side);
                box_.add(tube_.points[end] + side);
            }
    while (boxes_.back().size() > 1) {
        const std::size_t level = boxes_.size() - 1;
        std::vector<ShapeBox>& next = boxesOf(boxes_[level].size());
        for (std::size_t n = 0; n < boxes_[level].size(); ++n) {
            next[n / kOfBox].add(boxes_[level][n].low);
            next[n / kOfBox].add(boxes_[level][n].high);
        }
    }
}

bool TubeShape::meet(const ShapeRay& ray, std::uint32_t piece, Span& span) const {
    const glm::dvec3& a = tube_.points[pieces_[piece].from];
    const glm::dvec3& b = tube_.points[pieces_[piece].to];
    double from = 0, to = 0;
    bool met = false;
    const auto join = [&] { // convex: parts of one line through it are one
        span.from = met ? std::min(span.from, from) : from;
        span.to = met ? std::max(span.to, to) : to;
        met = true;
    };
    if (meetRound(ray.origin - a, ray.direction, tube_.radiusMm, from, to))
        join();
    if (pieces_[piece].to != pieces_[piece].from &&
        meetRound(ray.origin - b, ray.direction, tube_.radiusMm, from, to))
        join();
    if (meetCylinder(ray, a, b - a, tube_.radiusMm, from, to))
        join();
    span.first = span.last = piece;
    return met;
}

glm::dvec3 TubeShape::normalAt(const glm::dvec3& point, std::uint32_t piece) const {
    const glm::dvec3& a = tube_.points[pieces_[piece].from];
    const glm::dvec3 axis = tube_.points[pieces_[piece].to] - a;
    const double squared = glm::dot(axis, axis);
    const double along = squared > 0 ? std::clamp(glm::dot(point - a, axis) / squared, 0.0, 1.0) : 0;
    return point - (a + along * axis);
}

void TubeShape::forEachBall(const std::function<void(const glm::dvec3&, double)>& visit) const {
    for (const glm::dvec3& point : tube_.points)
        visit(point, tube_.radiusMm);
}

/// Rings of corners from pole to pole of each capsule.
void TubeShape::forEachTriangle(std::size_t from, std::size_t to, double within,
                                const VisitTriangle& visit) const {
    constexpr double kPi = std::numbers::pi;
    const double radius = tube_.radiusMm;
    const bool isThin = radius < 3 * within; // may be between the places where triangles are looked at
    const double angle = within < radius ? std::acos(1 - within / radius) : kPi / 3;
    const int around = std::clamp(static_cast<int>(std::ceil(kPi / angle)), 6, 256),
              quarter = (around + 3) / 4;
    std::vector<glm::dvec3> ring[2];
    for (std::size_t n = from; n < to; ++n) {
        const glm::dvec3 &a = tube_.points[pieces_[n].from], &b = tube_.points[pieces_[n].to];
        if (isThin) {
            visit(a, b, b);
            continue;
        }
        const double length = glm::distance(a, b);
        const glm::dvec3 along = length > 0 ? (b - a) / length : glm::dvec3(0, 0, 1);
        const glm::dvec3 least = std::abs(along.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
        const glm::dvec3 u = glm::normalize(glm::cross(along, least)), v = glm::cross(along, u);
        for (int r = 0; r <= 2 * quarter + 1; ++r) { // a half ball, then the other
            const bool first = r <= quarter;
            const double polar = kPi / 2 * (first ? r - quarter : r - quarter - 1) / quarter;
            const glm::dvec3 middle = (first ? a : b) + radius * std::sin(polar) * along;
            std::vector<glm::dvec3>&now = ring[r & 1], &before = ring[(r + 1) & 1];
            now.clear();
            for (int k = 0; k < around; ++k) {
                const double phi = 2 * kPi * k / around;
                now.push_back(middle + radius * std::cos(polar) * (std::cos(phi) * u + std::sin(phi) * v));
            }
            for (std::size_t k = 0; r > 0 && k < now.size(); ++k) {
                const std::size_t next = (k + 1) % now.size();
                visit(before[k], now[k], now[next]);
                visit(before[k], now[next], before[next]);
            }
        }
    }
}

void TubeShape::collect(const ShapeRay& ray, std::size_t level, std::size_t box,
                        std::vector<Span>& spans) const {
    if (!meetsBox(ray, boxes_[level][box]))
        return;
    const std::size_t parts = level > 0 ? boxes_[level - 1].size() : pieces_.size();
    const std::size_t last = std::min<std::size_t>((box + 1) * kOfBox, parts);
    for (std::size_t part = box * kOfBox; part < last; ++part)
        if (level > 0)
            collect(ray, level - 1, part, spans);
        else if (Span span{}; meet(ray, static_cast<std::uint32_t>(part), span))
            spans.push_back(span);
}

bool TubeShape::next(const ShapeRay& ray, const HitOrder& after, double most, const HitFilter& filter,
                     ShapeHit& hit) const {
    thread_local std::vector<Span> spans; // the largest that any ray of the thread has had
    spans.clear();
    collect(ray, boxes_.size() - 1, 0, spans);
    std::sort(spans.begin(), spans.end(), [](const Span& a, const Span& b) {
        return a.from != b.from ? a.from < b.from : a.first < b.first;
    });
    const auto tell = [&](double t, std::uint32_t piece) {
        const HitOrder at{t, piece};
        if (!(after < at && t < most && filter(t)))
            return false;
        hit = {at, normalAt(ray.origin + t * ray.direction, piece)};
        return true;
    };
    for (std::size_t n = 0; n < spans.size();) {
        Span whole = spans[n];
        for (++n; n < spans.size() && spans[n].from <= whole.to; ++n)
            if (spans[n].to > whole.to) {
                whole.to = spans[n].to;
                whole.last = spans[n].last;
            }
        if (tell(whole.from, whole.first) || tell(whole.to, whole.last))
            return true;
    }
    return false;
}

} // namespace tessera
