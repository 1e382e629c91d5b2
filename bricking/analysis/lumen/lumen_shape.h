// bricking/analysis/lumen/lumen_shape.h: a lumen as a shape in patient space: rays to its wall, the distance
// to the wall, and whether a line stays inside.
#pragma once

#include "bricking/analysis/lumen/lumen_values.h"
#include "bricking/analysis/lumen/voxel_set.h"

#include <array>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

namespace tessera {

// Evenly spread directions.

/// 42 unit vectors: the corners of an icosahedron and the middles of its edges. With each its opposite.
const std::array<glm::dvec3, 42>& directions42();

class LumenShape {
  public:
    /// Both must outlive it.
    LumenShape(const VoxelSet& voxels, const VolumeInfo& info);

    glm::dvec3 voxelOf(const glm::dvec3& mm) const {
        return glm::dvec3(voxelFromPatient_ * glm::dvec4(mm, 1));
    }
    glm::dvec3 mmOf(const glm::dvec3& place) const {
        return glm::dvec3(patientFromVoxel_ * glm::dvec4(place, 1));
    }
    glm::dvec3 middleOf(const glm::ivec3& voxel) const { return mmOf(glm::dvec3(voxel) + 0.5); }
    double smallestSpacingMm() const { return smallestMm_; }
    const VoxelSet& voxels() const { return voxels_; }

    /// True if the voxel at the point is lumen.
    bool holds(const glm::dvec3& mm) const { return voxels_.containsPlace(voxelOf(mm)); }
    /// The length of a ray through voxels of the lumen, mm; at most `most`.
    /// @param direction  unit
    double rayMm(const glm::dvec3& mm, const glm::dvec3& direction, double most) const;
    /// The lower quartile of ray lengths in all directions, mm: about the radius of a tube.
    double roughRadiusMm(const glm::dvec3& mm) const;

    /// Distance to the wall, mm; 0 outside. To the centre of the nearest voxel outside the lumen, exact for
    /// any affine, then back along that line to where trilinear values cross the threshold. Within four
    /// voxels of the wall it is the minimum of this and of 42 rays to that crossing.
    double wallMm(const glm::dvec3& mm, LumenValues& values, const LumenRule& rule) const;
    /// The distance of a wall's edge beyond the rule's threshold, mm. The edge is half way between the
    /// lumen's value and the wall's peak. The result is the median over those of 42 rays that meet the wall
    /// within 1.5 times wallMm; 0 if fewer than two do.
    /// @param wallMm  wall distance of the point, by the same rule
    /// @param lumen  the lumen's value, physical units
    double edgeBeyondMm(const glm::dvec3& mm, double wallMm, LumenValues& values, const LumenRule& rule,
                        double lumen) const;
    /// True if all of a straight line is lumen, by voxels and by trilinear values at every quarter of a
    /// voxel.
    bool staysInside(const glm::dvec3& fromMm, const glm::dvec3& toMm, LumenValues& values,
                     const LumenRule& rule) const;

  private:
    double nearestOutsideMm(const glm::dvec3& place, double most, glm::dvec3& outside) const;
    const VoxelSet& voxels_;
    glm::dmat4 patientFromVoxel_, voxelFromPatient_;
    glm::dmat3 mmFromStep_;
    glm::dvec3 halfBoxPerMm_; // of a ball of 1 mm, in voxels
    double smallestMm_;
};

} // namespace tessera
