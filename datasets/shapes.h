// datasets/shapes.h: the solids of the torso as signed distances in millimetres (negative inside). Distances
// are first-order approximations: exact at the surface, within a small factor elsewhere. That suffices for
// blending over one voxel and for pruning tiles. Only +, *, / and sqrt run per voxel, so the voxels do not
// depend on a maths library.
#pragma once

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <memory>
#include <vector>

namespace tessera {

struct Box {
    glm::vec3 low, high;
};

struct Range {
    float low, high;
};

class Shape {
  public:
    virtual ~Shape() = default;
    virtual float distance(const glm::vec3& p) const = 0;
    /// Holds distance() over the ball of radius r around c; may be wider.
    virtual Range bounds(const glm::vec3& c, float r) const {
        const float d = distance(c);
        return {d - kSteepest * r, d + kSteepest * r};
    }
    /// Holds every point at which distance() <= 0.
    virtual Box box() const = 0;

  protected:
    static constexpr float kSteepest = 1.6F; // the approximations' distances change at most this fast per mm
};

/// A straight round tube with spherical ends and linearly changing radius. If it is thinner than a voxel its
/// distance is increased so that its opacity falls with its width, instead of growing to a whole voxel.
class TubeSegment final : public Shape {
  public:
    TubeSegment(const glm::vec3& a, const glm::vec3& b, float radiusA, float radiusB, float voxelMm);
    float distance(const glm::vec3& p) const override;
    Box box() const override;

  private:
    glm::vec3 a_, ab_;
    float perLength2_, radiusA_, radiusGrowth_, voxelMm_;
};

/// A straight tube with elliptic section: radius r, but r / flatness along the unit vector `thin`.
class FlatSegment final : public Shape {
  public:
    FlatSegment(const glm::vec3& a, const glm::vec3& b, float radiusMm, float flatness,
                const glm::vec3& thin);
    float distance(const glm::vec3& p) const override;
    Box box() const override;

  private:
    glm::vec3 a_, ab_, thin_;
    float perLength2_, radius_, flatness_;
};

class Ellipsoid final : public Shape {
  public:
    /// The columns of `axes` are the directions of the half-axes radii.
    Ellipsoid(const glm::vec3& centre, const glm::vec3& radii, const glm::mat3& axes = glm::mat3(1));
    float distance(const glm::vec3& p) const override;
    Range bounds(const glm::vec3& c, float r) const override;
    Box box() const override;

  private:
    glm::vec3 centre_, perRadius_, perRadius2_;
    glm::mat3 localFromPatient_;
    float smallest_, largest_;
};

/// A vertebral body or disc: an elliptic cylinder along local z with rounded edges and a slight waist.
class Drum final : public Shape {
  public:
    Drum(const glm::vec3& centre, const glm::vec3& halfSize, float waist, const glm::mat3& axes);
    float distance(const glm::vec3& p) const override;
    Box box() const override;

  private:
    glm::vec3 centre_, half_;
    glm::mat3 localFromPatient_;
    float waist_;
};

/// One cross-section of a loft: half-width, half-depth in front of (y below) and behind its middle, middle y.
struct Section {
    float z, halfWidth, front, back, middleY;
};

/// A stack of squared-off ellipses, interpolated smoothly between the sections (z ascending).
class Loft final : public Shape {
  public:
    explicit Loft(const std::vector<Section>& sections);
    float distance(const glm::vec3& p) const override;
    Box box() const override;
    /// Point on the wall in the plane z: angle 0 is posterior (+y), +90 degrees is +x; moved outwards by mm.
    glm::vec3 wallPoint(float angleDegrees, float z, float outwardsMm) const;

  private:
    Section at(float z, Section* slope = nullptr) const; // slope: change of each per mm of z
    std::vector<Section> perMm_;                         // one every millimetre
};

/// Points with dot(normal, p) <= offset.
class HalfSpace final : public Shape {
  public:
    HalfSpace(const glm::vec3& normal, float offset) : normal_(normal), offset_(offset) {}
    float distance(const glm::vec3& p) const override { return glm::dot(normal_, p) - offset_; }
    Box box() const override { return {glm::vec3(-1e9F), glm::vec3(1e9F)}; }

  private:
    glm::vec3 normal_;
    float offset_;
};

using ShapeList = std::vector<std::unique_ptr<Shape>>;

/// A tube's course: a point and its radius.
struct Knot {
    glm::vec3 at;
    float radiusMm;
};

/// Points about stepMm apart on the Catmull-Rom curve through the knots (which it meets).
std::vector<Knot> curveThrough(const std::vector<Knot>& knots, float stepMm);
/// Adds the tube along curveThrough(knots).
void addTube(ShapeList& shapes, const std::vector<Knot>& knots, float voxelMm, float stepMm = 4);
/// Rotation whose local z is `direction`, local x as near to patient x as that allows.
glm::mat3 axesAlong(const glm::vec3& direction);
/// Left-right mirror image.
inline glm::vec3 mirrored(const glm::vec3& p, float side) {
    return {p.x * side, p.y, p.z};
}

/// A number in [0,1) that depends on its arguments alone.
float hashUnit(std::uint32_t a, std::uint32_t b = 0, std::uint32_t c = 0);

} // namespace tessera
