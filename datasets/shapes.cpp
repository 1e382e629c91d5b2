// datasets/shapes.cpp: see shapes.h.
#include "datasets/shapes.h"

#include <algorithm>
#include <numbers>

namespace tessera {
namespace {

constexpr float kSquareness = 0.35F; // of a body's section: 0 an ellipse, 1 a superellipse of order 4

float catmullRom(float a, float b, float c, float d, float t) {
    return b + 0.5F * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
}

Box boxOf(const glm::vec3& a, const glm::vec3& b, float reach) {
    return {glm::min(a, b) - reach, glm::max(a, b) + reach};
}

} // namespace

TubeSegment::TubeSegment(const glm::vec3& a, const glm::vec3& b, float radiusA, float radiusB, float voxelMm)
    : a_(a), ab_(b - a), perLength2_(1 / std::max(glm::dot(b - a, b - a), 1e-6F)), radiusA_(radiusA),
      radiusGrowth_(radiusB - radiusA), voxelMm_(voxelMm) {}

float TubeSegment::distance(const glm::vec3& p) const {
    const glm::vec3 fromA = p - a_;
    const float t = std::clamp(glm::dot(fromA, ab_) * perLength2_, 0.0F, 1.0F);
    const float radius = radiusA_ + t * radiusGrowth_;
    return glm::length(fromA - t * ab_) - radius + std::max(0.0F, 0.5F * voxelMm_ - radius);
}

Box TubeSegment::box() const {
    return boxOf(a_, a_ + ab_, std::max(radiusA_, radiusA_ + radiusGrowth_));
}

FlatSegment::FlatSegment(const glm::vec3& a, const glm::vec3& b, float radiusMm, float flatness,
                         const glm::vec3& thin)
    : a_(a), ab_(b - a), thin_(thin), perLength2_(1 / std::max(glm::dot(b - a, b - a), 1e-6F)),
      radius_(radiusMm), flatness_(flatness) {}

float FlatSegment::distance(const glm::vec3& p) const {
    const glm::vec3 fromA = p - a_;
    const float t = std::clamp(glm::dot(fromA, ab_) * perLength2_, 0.0F, 1.0F);
    const glm::vec3 q = fromA - t * ab_;
    const float across = glm::dot(q, thin_);
    const float k0 = glm::length(q + (flatness_ - 1) * across * thin_);
    const float k1 = glm::length(q + (flatness_ * flatness_ - 1) * across * thin_);
    return (k0 - radius_) * k0 / std::max(k1, 1e-6F);
}

Box FlatSegment::box() const {
    return boxOf(a_, a_ + ab_, radius_);
}

Ellipsoid::Ellipsoid(const glm::vec3& centre, const glm::vec3& radii, const glm::mat3& axes)
    : centre_(centre), perRadius_(1.0F / radii), perRadius2_(1.0F / (radii * radii)),
      localFromPatient_(glm::transpose(axes)), smallest_(std::min({radii.x, radii.y, radii.z})),
      largest_(std::max({radii.x, radii.y, radii.z})) {}

float Ellipsoid::distance(const glm::vec3& p) const {
    const glm::vec3 q = localFromPatient_ * (p - centre_);
    const float k0 = glm::length(q * perRadius_);
    const float k1 = glm::length(q * perRadius2_);
    return k1 > 1e-9F ? (k0 - 1) * k0 / k1 : -smallest_;
}

Range Ellipsoid::bounds(const glm::vec3& c, float r) const {
    // k0 / k1 lies between the smallest and the largest radius, and k0 changes at most 1 / smallest per mm
    const float k0 = glm::length(localFromPatient_ * (c - centre_) * perRadius_);
    const float low = k0 - r / smallest_ - 1, high = k0 + r / smallest_ - 1;
    return {low * (low > 0 ? smallest_ : largest_), high * (high > 0 ? largest_ : smallest_)};
}

Box Ellipsoid::box() const {
    return {centre_ - largest_, centre_ + largest_};
}

Drum::Drum(const glm::vec3& centre, const glm::vec3& halfSize, float waist, const glm::mat3& axes)
    : centre_(centre), half_(halfSize), localFromPatient_(glm::transpose(axes)), waist_(waist) {}

float Drum::distance(const glm::vec3& p) const {
    const glm::vec3 q = localFromPatient_ * (p - centre_);
    const float height = std::clamp(q.z / half_.z, -1.0F, 1.0F);
    const float shrink = 1 - waist_ * (1 - height * height);
    const float a = half_.x * shrink, b = half_.y * shrink;
    const float u = q.x / a, v = q.y / b;
    const float k0 = std::sqrt(u * u + v * v);
    const float k1 = std::sqrt(u * u / (a * a) + v * v / (b * b));
    const float radial = k1 > 1e-9F ? (k0 - 1) * k0 / k1 : -b;
    const float edge = 0.2F * half_.z; // the radius that rounds the rims
    const glm::vec2 outside(radial + edge, std::abs(q.z) - half_.z + edge);
    return glm::length(glm::max(outside, glm::vec2(0))) + std::min(std::max(outside.x, outside.y), 0.0F) -
           edge;
}

Box Drum::box() const {
    const float reach = half_.x + half_.z;
    return {centre_ - reach, centre_ + reach};
}

Loft::Loft(const std::vector<Section>& sections) {
    const float first = sections.front().z, last = sections.back().z;
    std::size_t at = 0;
    for (float z = first; z <= last; z += 1) {
        while (at + 2 < sections.size() && sections[at + 1].z <= z)
            ++at;
        const Section& a = sections[at > 0 ? at - 1 : 0];
        const Section& b = sections[at];
        const Section& c = sections[at + 1];
        const Section& d = sections[std::min(at + 2, sections.size() - 1)];
        const float t = (z - b.z) / (c.z - b.z);
        const auto mix = [&](float Section::*m) { return catmullRom(a.*m, b.*m, c.*m, d.*m, t); };
        perMm_.push_back(
            {z, mix(&Section::halfWidth), mix(&Section::front), mix(&Section::back), mix(&Section::middleY)});
    }
}

Section Loft::at(float z, Section* slope) const {
    const float offset = std::clamp(z - perMm_.front().z, 0.0F, static_cast<float>(perMm_.size() - 1));
    const std::size_t i = std::min(static_cast<std::size_t>(offset), perMm_.size() - 2);
    const float t = offset - static_cast<float>(i);
    const Section &a = perMm_[i], &b = perMm_[i + 1];
    const Section d{1, b.halfWidth - a.halfWidth, b.front - a.front, b.back - a.back, b.middleY - a.middleY};
    if (slope != nullptr)
        *slope = d;
    return {z, a.halfWidth + t * d.halfWidth, a.front + t * d.front, a.back + t * d.back,
            a.middleY + t * d.middleY};
}

float Loft::distance(const glm::vec3& p) const {
    Section slope{};
    const Section s = at(p.z, &slope);
    const float y = p.y - s.middleY;
    const float depth = y < 0 ? s.front : s.back;
    const float u = p.x / s.halfWidth, v = y / depth;
    const float u2 = u * u, v2 = v * v;
    const float norm2 = std::sqrt(u2 + v2) + 1e-6F;
    const float norm4 = std::sqrt(std::sqrt(u2 * u2 + v2 * v2)) + 1e-6F;
    const float g = (1 - kSquareness) * norm2 + kSquareness * norm4;
    const float cube = norm4 * norm4 * norm4;
    const float gu = (1 - kSquareness) * u / norm2 + kSquareness * u2 * u / cube;
    const float gv = (1 - kSquareness) * v / norm2 + kSquareness * v2 * v / cube;
    const float depthSlope = (y < 0 ? slope.front : slope.back) * v / depth;
    const float middleSlope = slope.middleY / depth;
    const float widthSlope = slope.halfWidth * u / s.halfWidth;
    const float gz = -gu * widthSlope - gv * (depthSlope + middleSlope);
    const float gx = gu / s.halfWidth, gy = gv / depth;
    const float side = (g - 1) / std::sqrt(gx * gx + gy * gy + gz * gz + 1e-9F);
    // flat ends
    return std::max({side, perMm_.front().z - p.z, p.z - perMm_.back().z});
}

Box Loft::box() const {
    Box box{glm::vec3(1e9F), glm::vec3(-1e9F)};
    for (const Section& s : perMm_) {
        box.low = glm::min(box.low, glm::vec3(-s.halfWidth, s.middleY - s.front, s.z));
        box.high = glm::max(box.high, glm::vec3(s.halfWidth, s.middleY + s.back, s.z));
    }
    return box;
}

glm::vec3 Loft::wallPoint(float angleDegrees, float z, float outwardsMm) const {
    const Section s = at(z);
    const float angle = angleDegrees * std::numbers::pi_v<float> / 180;
    const float u = std::sin(angle), v = std::cos(angle);
    const float norm4 = std::sqrt(std::sqrt(u * u * u * u + v * v * v * v));
    const float g = (1 - kSquareness) + kSquareness * norm4;
    const float depth = v < 0 ? s.front : s.back;
    return {(s.halfWidth + outwardsMm) * u / g, s.middleY + (depth + outwardsMm) * v / g, z};
}

std::vector<Knot> curveThrough(const std::vector<Knot>& knots, float stepMm) {
    std::vector<Knot> points;
    for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
        const Knot& a = knots[i > 0 ? i - 1 : 0];
        const Knot& b = knots[i];
        const Knot& c = knots[i + 1];
        const Knot& d = knots[std::min(i + 2, knots.size() - 1)];
        const int steps = std::max(1, static_cast<int>(std::ceil(glm::length(c.at - b.at) / stepMm)));
        for (int k = 0; k < steps; ++k) {
            const float t = static_cast<float>(k) / static_cast<float>(steps);
            glm::vec3 at;
            for (int axis = 0; axis < 3; ++axis)
                at[axis] = catmullRom(a.at[axis], b.at[axis], c.at[axis], d.at[axis], t);
            points.push_back({at, b.radiusMm + t * (c.radiusMm - b.radiusMm)});
        }
    }
    points.push_back(knots.back());
    return points;
}

void addTube(ShapeList& shapes, const std::vector<Knot>& knots, float voxelMm, float stepMm) {
    const std::vector<Knot> points = curveThrough(knots, stepMm);
    for (std::size_t i = 0; i + 1 < points.size(); ++i)
        shapes.push_back(std::make_unique<TubeSegment>(points[i].at, points[i + 1].at, points[i].radiusMm,
                                                       points[i + 1].radiusMm, voxelMm));
}

glm::mat3 axesAlong(const glm::vec3& direction) {
    const glm::vec3 z = glm::normalize(direction);
    const glm::vec3 hint = std::abs(z.x) < 0.9F ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
    const glm::vec3 x = glm::normalize(hint - glm::dot(hint, z) * z);
    return {x, glm::cross(z, x), z};
}

float hashUnit(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    std::uint32_t h = a * 0x9E3779B1U ^ (b * 0x85EBCA77U + 0x165667B1U) ^ (c * 0xC2B2AE3DU + 0x27D4EB2FU);
    for (int round = 0; round < 2; ++round) {
        h ^= h >> 15;
        h *= 0x2C1B3C6DU;
        h ^= h >> 12;
        h *= 0x297A2D39U;
    }
    h ^= h >> 15;
    return static_cast<float>(h >> 8) * 0x1p-24F;
}

} // namespace tessera
