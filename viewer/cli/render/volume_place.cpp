// viewer/cli/render/volume_place.cpp: see volume_place.h.
#include "viewer/cli/render/volume_place.h"

#include "core/base/error.h"
#include "render/plan/drawn_part.h"
#include "viewer/cli/options/options.h" // formatNumber

#include <array>
#include <glm/common.hpp>
#include <limits>

namespace tessera {
namespace {

/// "z from -400 to -1.5"
std::string rangeAlong(int axis, const VolumeInfo& info) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (int n = 0; n < 8; ++n) {
        const glm::dvec3 corner = glm::dvec3(info.extentVoxels) * glm::dvec3(n & 1, (n >> 1) & 1, n >> 2);
        const double at = (info.patientFromVoxel * glm::dvec4(corner, 1))[axis];
        low = std::min(low, at);
        high = std::max(high, at);
    }
    constexpr int kDigits = 6; // micrometres of a metre
    return std::string(1, "xyz"[axis]) + " from " + formatNumber(low, kDigits) + " to " +
           formatNumber(high, kDigits);
}

} // namespace

std::string placeOf(const VolumeInfo& info) {
    return rangeAlong(0, info) + ", " + rangeAlong(1, info) + " and " + rangeAlong(2, info) + " mm";
}

void requireSliceInVolume(const Scene& scene, const VolumeInfo& info, const std::string& where) {
    if (scene.mode != Mode::slice)
        return;
    Scene alone = scene;
    alone.cuts = {};
    if (drawnPart(alone, info).meets(glm::dvec3(0), glm::dvec3(info.extentVoxels)))
        return;
    const SlicePlane& slice = scene.slice;
    const std::string name = orientationNames()[static_cast<std::size_t>(slice.orientation)];
    constexpr std::array<int, 3> kAxes = {2, 1, 0}; // in the order of Orientation
    if (slice.orientation == Orientation::oblique)
        throw badFile(where, "a plane that meets the volume, which lies in " + placeOf(info),
                      "one outside it");
    throw badFile(where,
                  "a plane that meets the volume, in " +
                      rangeAlong(kAxes[static_cast<std::size_t>(slice.orientation)], info) + " mm",
                  name + ":" + formatNumber(slice.positionMm.value_or(0), 6));
}

} // namespace tessera
