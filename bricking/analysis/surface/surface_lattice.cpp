// bricking/analysis/surface/surface_lattice.cpp: see surface_lattice.h.
#include "bricking/analysis/surface/surface_lattice.h"

#include "core/base/brick.h"
#include "core/base/error.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tessera {
namespace {

constexpr double kMostShare = 1.0 / 16; // of an edge, that crossings keep from its ends
constexpr double kUlps = 4;             // that the least part of an edge must have

/// The plane at a place between samples, or beyond the outermost, where the field is theirs.
LatticePlane blendedPlane(double place, double pitch, int samples) {
    const double at = std::clamp(place / pitch - 0.5, 0.0, samples - 1.0);
    const int low = static_cast<int>(at);
    return {low, std::min(low + 1, samples - 1), at - low, place};
}

std::vector<LatticePlane> planesWithin(double low, double high, double pitch, int samples, double share) {
    const double inset = std::min(share * pitch, (high - low) / 4), gap = 2 * inset;
    std::vector<LatticePlane> planes{blendedPlane(low, pitch, samples),
                                     blendedPlane(low + inset, pitch, samples)};
    const int first = std::max(0, static_cast<int>(std::floor((low + gap) / pitch - 0.5)));
    for (int sample = first; sample < samples; ++sample) {
        const double place = pitch * (sample + 0.5);
        if (place > high - gap)
            break;
        if (place >= low + gap)
            planes.push_back({sample, sample, 0, place});
    }
    planes.push_back(blendedPlane(high - inset, pitch, samples));
    planes.push_back(blendedPlane(high, pitch, samples));
    return planes;
}

} // namespace

SurfaceLattice::SurfaceLattice(const VolumeInfo& info, const VoxelBox& box, int level,
                               const std::string& where)
    : level_(level), patientFromVoxel_(info.patientFromVoxel) {
    const PatientBox place = patientBoxOf(info);
    double farthest = 0;
    for (int axis = 0; axis < 3; ++axis)
        farthest = std::max({farthest, std::abs(place.low[axis]), std::abs(place.high[axis])});
    const double ulp = farthest * std::numeric_limits<float>::epsilon(), pitch = std::ldexp(1.0, level);
    const glm::dvec3 spacing = info.spacingMm() * pitch;
    const double least = std::min({spacing.x, spacing.y, spacing.z});
    leastShare_ = std::max(kLeastShareOfEdge, kUlps * ulp / least);
    if (leastShare_ > kMostShare)
        throw InputError(where +
                         ": expected a volume whose places in the patient fit numbers of 32 bits, "
                         "found samples of " +
                         numberText(least) + " mm, " + numberText(farthest) + " mm from the origin");
    const glm::ivec3 samples = levelExtent(info.extentVoxels, level);
    for (int axis = 0; axis < 3; ++axis) {
        const double low = std::max(0.0, box.low[axis]),
                     high = std::min(static_cast<double>(info.extentVoxels[axis]), box.high[axis]);
        if (!(high - low >= 8 * leastShare_))
            throw InputError(where +
                             ": expected a box that holds some of the volume, found none along axis " +
                             std::string(1, "xyz"[axis]));
        planes_[static_cast<std::size_t>(axis)] = planesWithin(low, high, pitch, samples[axis], leastShare_);
    }
}

glm::ivec3 SurfaceLattice::extent() const {
    return {static_cast<int>(planes_[0].size()), static_cast<int>(planes_[1].size()),
            static_cast<int>(planes_[2].size())};
}

glm::dvec3 SurfaceLattice::crossing(const glm::ivec3& at, int axis, double low, double high) const {
    double share = std::clamp(low / (low - high), leastShare_, 1 - leastShare_);
    if (isOutside(axis, at[axis]))
        share = 0;
    else if (isOutside(axis, at[axis] + 1))
        share = 1;
    glm::dvec3 place;
    for (int a = 0; a < 3; ++a)
        place[a] = planes(a)[static_cast<std::size_t>(at[a])].place;
    const double from = place[axis], to = planes(axis)[static_cast<std::size_t>(at[axis] + 1)].place;
    place[axis] = from + share * (to - from);
    return glm::dvec3(patientFromVoxel_ * glm::dvec4(place, 1));
}

} // namespace tessera
