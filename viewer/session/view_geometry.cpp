// viewer/session/view_geometry.cpp: see view_geometry.h.
#include "viewer/session/view_geometry.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
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

bool pictureFromPatient(const Camera& camera, const glm::ivec2& imageSize, const glm::dvec3& mm,
                        glm::dvec2& pixel) {
    const glm::dmat3 axes = patientFromCamera(camera);
    const glm::dvec3 c = glm::transpose(axes) * (mm - camera.position);
    const double half = glm::tan(glm::radians(camera.viewAngle) / 2);
    double perHeight = 0; // of half the picture's height, of a mm at that depth
    if (camera.projection == Projection::parallel)
        perHeight = 1 / camera.parallelScale;
    else if (c.z < -1e-9)
        perHeight = 1 / (-c.z * half);
    else
        return false;
    const double pixels = perHeight * imageSize.y / 2;
    pixel = {imageSize.x / 2.0 + c.x * pixels, imageSize.y / 2.0 - c.y * pixels};
    return true;
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

namespace {

glm::dvec3 middleOf(const VolumeInfo& info) {
    return glm::dvec3(info.patientFromVoxel * glm::dvec4(0.5 * glm::dvec3(info.extentVoxels), 1));
}

} // namespace

glm::dvec3 SliceFrame::patientFromPicture(const glm::dvec2& pixel) const {
    const glm::dvec2 mm = mmPerPixel * (pixel - 0.5 * glm::dvec2(size));
    return pose.point + mm.x * pose.right - mm.y * pose.up;
}

glm::dvec2 SliceFrame::pictureFromPatient(const glm::dvec3& mm) const {
    const glm::dvec3 way = mm - pose.point;
    return 0.5 * glm::dvec2(size) +
           glm::dvec2(glm::dot(way, pose.right), -glm::dot(way, pose.up)) / mmPerPixel;
}

SliceFrame sliceFrame(const VolumeInfo& info, Orientation orientation, const glm::dvec3& placeMm,
                      const glm::ivec2& size, double zoom) {
    SlicePlane plane;
    plane.orientation = orientation;
    const glm::dvec3 middle = middleOf(info);
    SliceFrame frame;
    frame.pose = poseOf(plane, middle);
    frame.size = size;
    // The box of the volume along the picture's axes.
    glm::dvec2 half(0);
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 voxel =
            glm::dvec3(info.extentVoxels) * glm::dvec3(corner & 1, corner >> 1 & 1, corner >> 2);
        const glm::dvec3 way = glm::dvec3(info.patientFromVoxel * glm::dvec4(voxel, 1)) - middle;
        half = glm::max(half,
                        glm::abs(glm::dvec2(glm::dot(way, frame.pose.right), glm::dot(way, frame.pose.up))));
    }
    const glm::dvec2 fits = 2.0 * half / glm::max(glm::dvec2(size), glm::dvec2(1));
    frame.mmPerPixel = std::max(std::max(fits.x, fits.y), 1e-9) / zoom;
    // Through the place; in the plane the middle stays the middle until the picture is nearer than all of it.
    const glm::dvec3 way = placeMm - middle;
    frame.pose.point = middle + glm::dot(way, frame.pose.normal) * frame.pose.normal;
    if (zoom > 1)
        frame.pose.point = placeMm - (placeMm - frame.pose.point) / zoom;
    return frame;
}

} // namespace tessera
