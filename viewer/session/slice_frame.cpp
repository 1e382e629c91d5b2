// viewer/session/slice_frame.cpp: see slice_frame.h.
#include "viewer/session/slice_frame.h"

#include <algorithm>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace tessera {
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
