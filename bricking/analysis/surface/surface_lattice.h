// bricking/analysis/surface/surface_lattice.h: SurfaceLattice: where the field of a volume, within a box, is
// taken for its surface.
//
// The planes along each axis are those of the samples' centres within the box, as docs/sampling.md places
// them, and two more at each end. One lies just inside the box's face, with the field there. The last lies on
// the face itself: it is outside, whatever the volume goes on with, so surfaces are closed there.
#pragma once

#include "core/base/volume.h"

#include <array>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

namespace tessera {

/// A plane of the lattice at right angles to one axis. The field there is a blend of two planes of samples,
/// (1 - weight) * low + weight * high.
struct LatticePlane {
    int low = 0, high = 0; // samples of the level
    double weight = 0;
    double place = 0; // voxels of level 0, from 0 at the volume's face
};

/// A box along a volume's axes, in voxels of level 0 from 0.
struct VoxelBox {
    glm::dvec3 low{0}, high{0};
};

class SurfaceLattice {
  public:
    /// @param box    within the volume and of some extent along every axis
    /// @param level  0 to kLevelCount - 1, whose samples are taken
    /// Throws InputError naming where for an empty box, and where numbers of 32 bits cannot tell places of
    /// the lattice apart that far from the patient's origin.
    SurfaceLattice(const VolumeInfo& info, const VoxelBox& box, int level, const std::string& where);

    int level() const { return level_; }
    const std::vector<LatticePlane>& planes(int axis) const {
        return planes_[static_cast<std::size_t>(axis)];
    }
    /// Planes along each axis: at least four.
    glm::ivec3 extent() const;
    /// True of the first and last plane of an axis.
    bool isOutside(int axis, int plane) const {
        return plane == 0 || plane + 1 == static_cast<int>(planes(axis).size());
    }

    /// Where the field crosses the value along an edge of the lattice, mm in patient space.
    /// @param at     its low end, planes along each axis
    /// @param low, high  the field at its ends minus the value; one of them below 0, the other not. An end
    ///     that is outside has any value below 0: the crossing is there
    glm::dvec3 crossing(const glm::ivec3& at, int axis, double low, double high) const;

  private:
    int level_;
    std::array<std::vector<LatticePlane>, 3> planes_;
    glm::dmat4 patientFromVoxel_;
    double leastShare_;
};

/// The least distance between a crossing and the ends of its edge, as a share of the edge: so no triangle
/// degenerates where a sample has the very value.
constexpr double kLeastShareOfEdge = 1.0 / 1024;

} // namespace tessera
