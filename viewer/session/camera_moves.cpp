// viewer/session/camera_moves.cpp: see camera_moves.h.
#include "viewer/session/camera_moves.h"

#include <algorithm>
#include <cmath>
#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
#include <glm/trigonometric.hpp>

namespace tessera {
namespace {

constexpr double kNearestMm = 1e-3, kFarthestMm = 1e7;
constexpr double kWidestDegrees = 170;

struct Axes {
    glm::dvec3 right, up, towards; // unit
};

Axes axesOf(const Camera& camera) {
    const glm::dmat3 axes = patientFromCamera(camera);
    return {axes[0], axes[1], axes[2]};
}

glm::dvec3 turned(const glm::dvec3& v, double angle, const glm::dvec3& axis) {
    return glm::dvec3(glm::rotate(glm::dmat4(1), angle, axis) * glm::dvec4(v, 0));
}

Camera movedBy(Camera camera, const glm::dvec3& mm) {
    camera.position += mm;
    camera.focalPoint += mm;
    return camera;
}

} // namespace

double focalDistanceMm(const Camera& camera) {
    return glm::length(camera.position - camera.focalPoint);
}

double halfHeightMm(const Camera& camera) {
    return camera.projection == Projection::parallel
               ? camera.parallelScale
               : focalDistanceMm(camera) * std::tan(glm::radians(camera.viewAngle) / 2);
}

Camera orbited(const Camera& camera, const glm::dvec2& angles) {
    const Axes a = axesOf(camera);
    Camera moved = camera;
    glm::dvec3 arm = camera.position - camera.focalPoint, up = a.up;
    arm = turned(arm, angles.x, a.up);
    const glm::dvec3 right = turned(a.right, angles.x, a.up);
    arm = turned(arm, -angles.y, right);
    up = turned(up, -angles.y, right);
    moved.position = camera.focalPoint + arm;
    moved.viewUp = glm::normalize(up);
    return moved;
}

Camera panned(const Camera& camera, const glm::dvec2& heights) {
    const Axes a = axesOf(camera);
    const double mm = 2 * halfHeightMm(camera);
    return movedBy(camera, mm * (heights.y * a.up - heights.x * a.right));
}

Camera zoomed(const Camera& camera, double factor) {
    Camera moved = camera;
    const glm::dvec3 arm = camera.position - camera.focalPoint;
    if (camera.projection == Projection::parallel) {
        moved.parallelScale = std::clamp(camera.parallelScale / factor, kNearestMm, kFarthestMm);
        return moved;
    }
    const double before = glm::length(arm);
    moved.position =
        camera.focalPoint + arm * (std::clamp(before / factor, kNearestMm, kFarthestMm) / before);
    return moved;
}

Camera zoomedAt(const Camera& camera, double factor, const glm::dvec2& place) {
    const Axes a = axesOf(camera);
    const Camera moved = zoomed(camera, factor);
    const double mm = 2 * (halfHeightMm(camera) - halfHeightMm(moved));
    return movedBy(moved, mm * (place.x * a.right - place.y * a.up));
}

Camera rolled(const Camera& camera, double angle) {
    const Axes a = axesOf(camera);
    Camera moved = camera;
    moved.viewUp = turned(a.up, angle, a.towards);
    return moved;
}

Camera flown(const Camera& camera, const glm::dvec3& mm, const glm::dvec2& angles) {
    const Axes a = axesOf(camera);
    Camera moved = movedBy(camera, mm.x * a.right + mm.y * a.up - mm.z * a.towards);
    glm::dvec3 gaze = moved.focalPoint - moved.position;
    gaze = turned(gaze, -angles.x, a.up);
    const glm::dvec3 right = turned(a.right, -angles.x, a.up);
    moved.focalPoint = moved.position + turned(gaze, angles.y, right);
    moved.viewUp = turned(a.up, angles.y, right);
    return moved;
}

Camera centredOn(const Camera& camera, const glm::dvec3& point) {
    return movedBy(camera, point - camera.focalPoint);
}

Camera seenFrom(const Camera& camera, View view) {
    const ViewAxes axes = viewAxes(view);
    Camera moved = camera;
    moved.position = camera.focalPoint + focalDistanceMm(camera) * axes.towards;
    moved.viewUp = axes.up;
    return moved;
}

Camera heldBy(const Camera& camera, const glm::ivec2& from, const glm::ivec2& to) {
    const auto aspect = [](const glm::ivec2& size) { return static_cast<double>(size.x) / size.y; };
    const double factor = aspect(from) / aspect(to);
    Camera held = camera;
    if (!(factor > 1))
        return held;
    held.parallelScale *= factor;
    const double half = std::tan(glm::radians(camera.viewAngle) / 2) * factor;
    held.viewAngle = std::min(2 * glm::degrees(std::atan(half)), kWidestDegrees);
    return held;
}

Camera projectedBy(const Camera& camera, Projection projection) {
    if (camera.projection == projection)
        return camera;
    Camera moved = camera;
    moved.projection = projection;
    const double half = halfHeightMm(camera);
    if (projection == Projection::parallel) {
        moved.parallelScale = half;
        return moved;
    }
    const glm::dvec3 towards = glm::normalize(camera.position - camera.focalPoint);
    moved.position = camera.focalPoint + towards * (half / std::tan(glm::radians(camera.viewAngle) / 2));
    return moved;
}

} // namespace tessera
