// core/scene/camera.cpp: see camera.h.
#include "core/scene/camera.h"

#include "core/base/error.h"
#include "core/base/magnitude.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <limits>
#include <utility>

namespace tessera {
namespace {

struct Ball {
    glm::dvec3 centre{0};
    double radius = 0;
};

std::array<glm::dvec3, 8> corners(const VolumeInfo& info) {
    std::array<glm::dvec3, 8> out;
    for (std::size_t i = 0; i < 8; ++i)
        out[i] = glm::dvec3(
            info.patientFromVoxel *
            glm::dvec4(glm::dvec3(info.extentVoxels) * glm::dvec3(i & 1, (i >> 1) & 1, i >> 2), 1));
    return out;
}

/// Smallest ball around the volume's centre that holds its eight corners.
Ball boundingBall(const VolumeInfo& info) {
    const glm::dvec3 centre(info.patientFromVoxel * glm::dvec4(0.5 * glm::dvec3(info.extentVoxels), 1));
    double radius = 0;
    for (const glm::dvec3& corner : corners(info))
        radius = std::max(radius, glm::length(corner - centre));
    return {centre, radius};
}

} // namespace

void Camera::validate(const std::string& where) const {
    const auto refuse = [&](const std::string& text) { return InputError(where + ": " + text); };
    checkPlace(position, "a position", where);
    checkPlace(focalPoint, "a focalPoint", where);
    checkDirection(viewUp, "a viewUp", where);
    const glm::dvec3 view = focalPoint - position;
    if (!(glm::length(view) >= kShortestDirection))
        throw refuse("expected position and focalPoint to differ");
    if (!(glm::length(glm::cross(view, viewUp)) > 1e-9 * glm::length(view) * glm::length(viewUp)))
        throw refuse("expected a viewUp that is not parallel to the direction of view");
    if (projection == Projection::perspective && !(viewAngle > 0 && viewAngle < 180))
        throw refuse("expected viewAngle between 0 and 180 degrees, found " + shownNumber(viewAngle));
    if (projection == Projection::parallel && !(parallelScale > 0 && parallelScale <= kFarthestPlaceMm))
        throw refuse("expected a positive parallelScale in mm, at most 1e+12, found " +
                     shownNumber(parallelScale));
}

ViewAxes viewAxes(View view) {
    // LPS: +x is the patient's left, +y posterior, +z superior. Looking at the anterior side means looking
    // towards +y, so the patient's left comes out on the picture's right, as radiologists expect.
    ViewAxes axes{{}, {0, 0, 1}, {}};
    switch (view) {
    case View::anterior:
        axes.towards = {0, -1, 0};
        break;
    case View::posterior:
        axes.towards = {0, 1, 0};
        break;
    case View::left:
        axes.towards = {1, 0, 0};
        break;
    case View::right:
        axes.towards = {-1, 0, 0};
        break;
    case View::superior:
        axes.towards = {0, 0, 1}, axes.up = {0, -1, 0};
        break;
    case View::inferior:
        axes.towards = {0, 0, -1}, axes.up = {0, -1, 0};
        break;
    }
    axes.right = glm::cross(-axes.towards, axes.up);
    return axes;
}

ViewAxes viewAxes(const ViewAngles& angles) {
    const auto sine = [](double degrees) {
        const double within = std::fmod(degrees, 360.0);
        for (const auto& [at, value] : {std::pair{0.0, 0.0}, {90.0, 1.0}, {180.0, 0.0}, {270.0, -1.0}})
            if (within == at || within == at - 360)
                return value;
        return std::sin(glm::radians(within));
    };
    const double s = sine(angles.turn), c = sine(angles.turn + 90);
    const double up = sine(angles.rise), level = sine(angles.rise + 90);
    ViewAxes axes;
    axes.towards = {level * s, -level * c, up};
    axes.up = {-up * s, up * c, level};
    axes.right = glm::cross(-axes.towards, axes.up);
    return axes;
}

namespace {
constexpr double kViewAngle = 30; // degrees, of cameras that are fitted
constexpr double kMargin = 1.03;  // half of the picture relative to the half that the fitted object takes
} // namespace

ViewFit::ViewFit(const ViewAxes& axes, Projection projection, const glm::ivec2& imageSize)
    : axes_(axes), projection_(projection), aspect_(static_cast<double>(imageSize.x) / imageSize.y),
      tangent_(0) {
    if (projection == Projection::perspective)
        tangent_ = std::tan(glm::radians(kViewAngle) / 2) / kMargin * glm::dvec2(aspect_, 1);
    nearest_ = -std::numeric_limits<double>::infinity();
    farthest_ = -nearest_;
    reach_.fill(nearest_);
}

// A point at (u, v, s) is inside a picture whose eye is at (u0, v0, d) where |u - u0| <= tangent * (d - s),
// that is where u + tangent s <= u0 + tangent d and -u + tangent s <= -u0 + tangent d. The left sides do not
// depend on the eye.
std::array<double, 4> ViewFit::reachOf(const glm::dvec3& centre, const glm::dvec3& half) const {
    const glm::dvec2 depth = tangent_ * (centre.z + half.z);
    return {centre.x + half.x + depth.x, -centre.x + half.x + depth.x, centre.y + half.y + depth.y,
            -centre.y + half.y + depth.y};
}

void ViewFit::add(const glm::dvec3& centre, const glm::dvec3& half) {
    const std::array<double, 4> reach = reachOf(centre, half);
    for (std::size_t side = 0; side < reach.size(); ++side)
        reach_[side] = std::max(reach_[side], reach[side]);
    nearest_ = std::max(nearest_, centre.z + half.z);
    farthest_ = std::min(farthest_, centre.z - half.z);
}

void ViewFit::add(const ViewFit& other) {
    for (std::size_t side = 0; side < reach_.size(); ++side)
        reach_[side] = std::max(reach_[side], other.reach_[side]);
    nearest_ = std::max(nearest_, other.nearest_);
    farthest_ = std::min(farthest_, other.farthest_);
}

bool ViewFit::holds(const glm::dvec3& centre, const glm::dvec3& half) const {
    const std::array<double, 4> reach = reachOf(centre, half);
    return std::equal(reach.begin(), reach.end(), reach_.begin(), std::less_equal<>());
}

Camera ViewFit::camera() const {
    TESSERA_CHECK(!empty());
    const glm::dvec2 middle(0.5 * (reach_[0] - reach_[1]), 0.5 * (reach_[2] - reach_[3]));
    const glm::dvec2 half(0.5 * (reach_[0] + reach_[1]), 0.5 * (reach_[2] + reach_[3]));
    Camera camera;
    camera.projection = projection_;
    camera.viewAngle = kViewAngle;
    camera.viewUp = axes_.up;
    camera.focalPoint =
        axes_.right * middle.x + axes_.up * middle.y + axes_.towards * (0.5 * (nearest_ + farthest_));
    const bool perspective = projection_ == Projection::perspective;
    if (!perspective) // a parallel view has no distance: the eye is in front of everything
        camera.parallelScale = kMargin * std::max(half.x / aspect_, half.y);
    const double eye = perspective ? std::max(half.x / tangent_.x, half.y / tangent_.y)
                                   : nearest_ + 4 * camera.parallelScale;
    camera.position = camera.focalPoint + axes_.towards * (eye - 0.5 * (nearest_ + farthest_));
    return camera;
}

Camera fitCamera(const VolumeInfo& info, const ViewAxes& axes, Projection projection,
                 const glm::ivec2& imageSize) {
    Camera camera;
    camera.projection = projection;
    camera.focalPoint = boundingBall(info).centre;
    camera.viewUp = axes.up;
    camera.viewAngle = kViewAngle;
    // Every corner of the volume inside the picture, with the volume's centre in its middle.
    const double aspect = static_cast<double>(imageSize.x) / imageSize.y;
    const double tangent = std::tan(glm::radians(camera.viewAngle) / 2) / kMargin;
    double distance = 0, scale = 0;
    for (const glm::dvec3& corner : corners(info)) {
        const glm::dvec3 p = corner - camera.focalPoint;
        const double half =
            std::max(std::abs(glm::dot(p, axes.up)), std::abs(glm::dot(p, axes.right)) / aspect);
        distance = std::max(distance, half / tangent + glm::dot(p, axes.towards));
        scale = std::max(scale, half * kMargin);
    }
    camera.position = camera.focalPoint + axes.towards * distance;
    camera.parallelScale = scale;
    return camera;
}

glm::dmat3 patientFromCamera(const Camera& camera) {
    const glm::dvec3 towards = glm::normalize(camera.position - camera.focalPoint);
    const glm::dvec3 right = glm::normalize(glm::cross(camera.viewUp, towards));
    return {right, glm::cross(towards, right), towards};
}

RayPlane rayPlane(const Camera& camera, const VolumeInfo& info, const glm::ivec2& imageSize) {
    RayPlane plane;
    plane.forward = glm::normalize(camera.focalPoint - camera.position);
    const glm::dvec3 right = glm::normalize(glm::cross(plane.forward, camera.viewUp));
    const glm::dvec3 up = glm::cross(right, plane.forward);
    const Ball ball = boundingBall(info);
    const double aspect = static_cast<double>(imageSize.x) / imageSize.y;
    // The plane goes through the volume's centre, but never closer than a radius, so that it stays in front
    // of a camera inside the volume or looking away from it.
    const double distance = std::max(glm::dot(ball.centre - camera.position, plane.forward), ball.radius);
    plane.perspective = camera.projection == Projection::perspective;
    plane.centre = camera.position + distance * plane.forward;
    plane.toCentre = distance * plane.forward;
    const double half =
        plane.perspective ? distance * std::tan(glm::radians(camera.viewAngle) / 2) : camera.parallelScale;
    plane.up = half * up;
    plane.right = half * aspect * right;
    return plane;
}

PatientRay pixelRay(const RayPlane& plane, const glm::dvec2& pixel, const glm::ivec2& imageSize) {
    const double x = 2 * pixel.x / imageSize.x - 1, y = 1 - 2 * pixel.y / imageSize.y;
    const glm::dvec3 offset = x * plane.right + y * plane.up;
    PatientRay ray;
    ray.base = plane.centre + offset;
    if (plane.perspective) {
        const glm::dvec3 fromEye = plane.toCentre + offset;
        ray.minT = -glm::length(fromEye);
        ray.direction = fromEye / -ray.minT;
    } else {
        ray.minT = -std::numeric_limits<double>::infinity();
        ray.direction = plane.forward;
    }
    return ray;
}

} // namespace tessera
