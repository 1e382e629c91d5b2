// viewer/annotations/shown_plane.cpp: see shown_plane.h.
#include "viewer/annotations/shown_plane.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace tessera {

ShownPlane planeOf(const SlicePlane& slice, const VolumeInfo& info) {
    const SlicePose pose =
        poseOf(slice, glm::dvec3(info.patientFromVoxel * glm::dvec4(0.5 * glm::dvec3(info.extentVoxels), 1)));
    double voxel = 0;
    for (int axis = 0; axis < 3; ++axis)
        voxel += std::abs(glm::dot(glm::dvec3(info.patientFromVoxel[axis]), pose.normal));
    return {pose.point, pose.normal, 0.5 * std::max(slice.thicknessMm, voxel)};
}

} // namespace tessera
