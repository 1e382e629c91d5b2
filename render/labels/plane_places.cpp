// render/labels/plane_places.cpp: see plane_places.h.
#include "render/labels/plane_places.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace tessera {
namespace {

/// From a map to patient space.
PlanePlaces inVoxels(PlanePlaces places, const VolumeInfo& info) {
    const glm::dmat4 voxelFromPatient = glm::inverse(info.patientFromVoxel);
    const glm::dmat3 linear(voxelFromPatient);
    const glm::dvec3 origin(voxelFromPatient[3]);
    for (int i = 0; i < 3; ++i)
        places.toPlace[i] = linear * places.toPlace[i] + places.toW[i] * origin;
    return places;
}

} // namespace

std::optional<glm::dvec3> PlanePlaces::at(const glm::dvec2& pixel) const {
    const glm::dvec3 p(pixel, 1);
    if (!perspective)
        return toPlace * p;
    const double w = glm::dot(toW, p);
    if (!(w > 0))
        return std::nullopt;
    return toPlace * p / w;
}

double SurfacePlaces::voxelsPerPixel() const {
    double least = HUGE_VAL;
    for (const glm::dvec2& part : {glm::dvec2(0.5), {0, 0}, {1, 0}, {0, 1}, {1, 1}}) {
        const glm::dvec2 pixel = part * glm::dvec2(size);
        const auto here = at(pixel), right = at(pixel + glm::dvec2(1, 0)),
                   down = at(pixel + glm::dvec2(0, 1));
        if (here && right && down)
            least = std::min({least, glm::length(*right - *here), glm::length(*down - *here)});
    }
    return least;
}

PlanePlaces planePlaces(const Camera& camera, const SlicePlane& slice, const VolumeInfo& info,
                        const glm::ivec2& imageSize) {
    const glm::dvec4 middle(0.5 * glm::dvec3(info.extentVoxels), 1);
    const SlicePose plane = poseOf(slice, glm::dvec3(info.patientFromVoxel * middle));
    const RayPlane rays = rayPlane(camera, info, imageSize);
    PlanePlaces places;
    places.size = imageSize;
    // Of (x, y, 1): how far a ray's start lies from the middle of the rays' plane.
    const glm::dvec3 right = 2.0 / imageSize.x * rays.right, down = -2.0 / imageSize.y * rays.up,
                     corner = rays.up - rays.right;
    if (!rays.perspective) {
        const double facing = glm::dot(plane.normal, rays.forward);
        places.isMet = std::abs(facing) > 1e-9;
        const auto onPlane = [&](const glm::dvec3& way) {
            return way - glm::dot(plane.normal, way) / facing * rays.forward;
        };
        if (places.isMet)
            places.toPlace = glm::dmat3(onPlane(right), onPlane(down),
                                        plane.point + onPlane(rays.centre + corner - plane.point));
        return inVoxels(places, info);
    }
    // eye + height / w * direction, w the direction along the normal, both of (x, y, 1).
    const glm::dvec3 eye = rays.centre - rays.toCentre;
    const double height = glm::dot(plane.normal, plane.point - eye), side = height < 0 ? -1 : 1;
    const glm::dmat3 direction(right, down, rays.toCentre + corner);
    places.perspective = true;
    places.isMet = height != 0;
    for (int i = 0; i < 3; ++i) {
        places.toW[i] = side * glm::dot(plane.normal, direction[i]);
        places.toPlace[i] = places.toW[i] * eye + std::abs(height) * direction[i];
    }
    return inVoxels(places, info);
}

PlanePlaces planePlaces(const SlicePose& plane, double mmPerPixel, const VolumeInfo& info,
                        const glm::ivec2& imageSize) {
    PlanePlaces places;
    places.size = imageSize;
    const glm::dvec3 right = mmPerPixel * plane.right, down = -mmPerPixel * plane.up;
    const glm::dvec2 half = 0.5 * glm::dvec2(imageSize);
    places.toPlace = glm::dmat3(right, down, plane.point - half.x * right - half.y * down);
    return inVoxels(places, info);
}

} // namespace tessera
