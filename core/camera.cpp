// core/camera.cpp: see camera.h.
#include "core/camera.h"

#include "core/error.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <limits>

namespace tessera {
namespace {

struct Ball {
    glm::dvec3 centre{0};
    double radius = 0;
};

/// Smallest ball around the volume's centre that holds its eight corners.
Ball boundingBall(const VolumeInfo& info) {
    const glm::dvec3 extent(info.extentVoxels);
    const glm::dvec3 centre(info.patientFromVoxel * glm::dvec4(0.5 * extent, 1));
    double radius = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 at = extent * glm::dvec3(corner & 1, (corner >> 1) & 1, corner >> 2);
        radius = std::max(radius, glm::length(glm::dvec3(info.patientFromVoxel * glm::dvec4(at, 1)) - centre));
    }
    return {centre, radius};
}

} // namespace

void Camera::validate(const std::string& where) const {
    const auto refuse = [&](const std::string& text) { return InputError(where + ": " + text); };
    for (int i = 0; i < 3; ++i)
        if (!std::isfinite(position[i]) || !std::isfinite(focalPoint[i]) || !std::isfinite(viewUp[i]))
            throw refuse("expected finite numbers in position, focalPoint and viewUp");
    const glm::dvec3 view = focalPoint - position;
    if (!(glm::length(view) > 0)) throw refuse("expected position and focalPoint to differ");
    if (!(glm::length(glm::cross(view, viewUp)) > 1e-9 * glm::length(view) * glm::length(viewUp)))
        throw refuse("expected a viewUp that is not parallel to the direction of view");
    if (projection == Projection::perspective && !(viewAngle > 0 && viewAngle < 180))
        throw refuse("expected viewAngle between 0 and 180 degrees, found " + std::to_string(viewAngle));
    if (projection == Projection::parallel && !(parallelScale > 0 && std::isfinite(parallelScale)))
        throw refuse("expected a positive parallelScale in mm, found " + std::to_string(parallelScale));
}

Camera fitCamera(const VolumeInfo& info, View view, Projection projection, const glm::ivec2& imageSize) {
    // LPS: +x is the patient's left, +y posterior, +z superior. Looking at the anterior side means looking
    // towards +y, so the patient's left comes out on the picture's right, as radiologists expect.
    glm::dvec3 side(0), up(0, 0, 1);
    switch (view) {
    case View::anterior: side = {0, -1, 0}; break;
    case View::posterior: side = {0, 1, 0}; break;
    case View::left: side = {1, 0, 0}; break;
    case View::right: side = {-1, 0, 0}; break;
    case View::superior: side = {0, 0, 1}, up = {0, -1, 0}; break;
    case View::inferior: side = {0, 0, -1}, up = {0, -1, 0}; break;
    }
    const Ball ball = boundingBall(info);
    // A wide picture is limited by its height; a tall one by its width, so the angle across it must hold.
    const double narrow = std::min(1.0, static_cast<double>(imageSize.x) / imageSize.y);
    Camera camera;
    camera.projection = projection;
    camera.focalPoint = ball.centre;
    camera.viewUp = up;
    camera.viewAngle = 30;
    const double halfAngle = std::atan(narrow * std::tan(glm::radians(camera.viewAngle) / 2));
    camera.position = ball.centre + side * (ball.radius / std::sin(halfAngle));
    camera.parallelScale = ball.radius / narrow;
    return camera;
}

RayPlane rayPlane(const Camera& camera, const VolumeInfo& info, const glm::ivec2& imageSize) {
    RayPlane plane;
    plane.forward = glm::normalize(camera.focalPoint - camera.position);
    const glm::dvec3 right = glm::normalize(glm::cross(plane.forward, camera.viewUp));
    const glm::dvec3 up = glm::cross(right, plane.forward);
    const Ball ball = boundingBall(info);
    const double aspect = static_cast<double>(imageSize.x) / imageSize.y;
    // The plane goes through the volume's centre, but never closer than a radius, so that it stays in front of
    // a camera inside the volume or looking away from it.
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
