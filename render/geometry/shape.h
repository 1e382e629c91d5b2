// render/geometry/shape.h: Shape: a surface that rays meet (docs/sampling.md, "Meshes"): triangles
// (mesh_shape.h) or a closed form (tube_shape.h). All in double, so that every engine gets the same points.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <limits>

namespace tessera {

/// origin + t * direction in patient space, mm; the direction has any length.
struct ShapeRay {
    glm::dvec3 origin{0}, direction{0};
};

/// A place in the order of a ray's hits of one shape: by t, those of equal t by the number of their part.
struct HitOrder {
    double t = -std::numeric_limits<double>::max();
    std::uint32_t part = 0;
    friend constexpr bool operator<(const HitOrder& a, const HitOrder& b) {
        return a.t != b.t ? a.t < b.t : a.part < b.part;
    }
};

struct ShapeHit {
    HitOrder at;
    glm::dvec3 normal{0}; // of the surface, patient space, any length, to either side; 0: it has none
    glm::dvec3 plane{
        0}; // normal of the triangle, of any length, where the above is between its corners'; else 0
    const glm::dvec3* colour = nullptr; // of the shape's own, which outlives it; linear light; null: none
};

/// Says which hits count: a function without state of its own, and what it works on.
struct HitFilter {
    bool (*keeps)(const void* context, double t) = nullptr; // null: all
    const void* context = nullptr;
    bool operator()(double t) const { return !keeps || keeps(context, t); }
};

struct ShapeBox {
    glm::dvec3 low{std::numeric_limits<double>::max()}, high{-std::numeric_limits<double>::max()}; // mm
    void add(const glm::dvec3& p) {
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = p[axis] < low[axis] ? p[axis] : low[axis];
            high[axis] = p[axis] > high[axis] ? p[axis] : high[axis];
        }
    }
};

class Shape {
  public:
    virtual ~Shape() = default;
    /// The first hit behind `after` that the filter keeps, before most. False: there is none. Thread-safe.
    virtual bool next(const ShapeRay& ray, const HitOrder& after, double most, const HitFilter& filter,
                      ShapeHit& hit) const = 0;
    virtual const ShapeBox& box() const = 0;
    /// Balls whose hull holds the surface and touches it on every side, mm: for fitting cameras.
    virtual void
    forEachBall(const std::function<void(const glm::dvec3& centre, double radius)>& visit) const = 0;
    /// Triangles, or pieces of a line.
    virtual std::size_t parts() const = 0;
    /// Corners of a triangle; where the last two are the same point, a line.
    using VisitTriangle = std::function<void(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c)>;
    /// The surface of parts [from,to) as triangles, which may go through one another. Thread-safe.
    /// @param within  mm: how far a triangle may lie off a round surface; tubes of less than three times that
    /// are lines
    virtual void forEachTriangle(std::size_t from, std::size_t to, double within,
                                 const VisitTriangle& visit) const = 0;
    /// What the parts are, for people: "triangles".
    virtual const char* partName() const = 0;
    /// RAM, charged.
    virtual std::size_t bytes() const = 0;
};

} // namespace tessera
