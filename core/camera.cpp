// core/camera.cpp: see camera.h.
#include "core/camera.h"

#include "core/error.h"

#include <algorithm>
#include <array>
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
    for (int i = 0; i < 3; ++i)
        if (!std::isfinite(position[i]) || !std::isfinite(focalPoint[i]) || !std::isfinite(viewUp[i]))
            throw refuse("expected finite numbers in position, focalPoint and viewUp");
    const glm::dvec3 view = focalPoint - position;
    if (!(glm::length(view) > 0))
        throw refuse("expected position and focalPoint to differ");
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
    case View::anterior:
        side = {0, -1, 0};
        break;
    case View::posterior:
        side = {0, 1, 0};
        break;
    case View::left:
        side = {1, 0, 0};
        break;
    case View::right:
        side = {-1, 0, 0};
        break;
    case View::superior:
        side = {0, 0, 1}, up = {0, -1, 0};
        break;
    case View::inferior:
        side = {0, 0, -1}, up = {0, -1, 0};
        break;
    }
    Camera camera;
    camera.projection = projection;
    camera.focalPoint = boundingBall(info).centre;
    camera.viewUp = up;
    camera.viewAngle = 30;
    // Every corner of the volume inside the picture, with a margin of 3 % around the tightest one.
    constexpr double kMargin = 1.03;
    const double aspect = static_cast<double>(imageSize.x) / imageSize.y;
    const glm::dvec3 right = glm::cross(-side, up);
    const double tangent = std::tan(glm::radians(camera.viewAngle) / 2) / kMargin;
    double distance = 0, scale = 0;
    for (const glm::dvec3& corner : corners(info)) {
        const glm::dvec3 p = corner - camera.focalPoint;
        const double half = std::max(std::abs(glm::dot(p, up)), std::abs(glm::dot(p, right)) / aspect);
        distance = std::max(distance, half / tangent + glm::dot(p, side));
        scale = std::max(scale, half * kMargin);
    }
    camera.position = camera.focalPoint + side * distance;
    camera.parallelScale = scale;
    return camera;
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
