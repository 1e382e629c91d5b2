// bricking/analysis/lumen/lumen_shape.h: a lumen as a shape in patient space: rays to its wall, the distance
// to the wall, and whether a line stays inside.
#pragma once

#include "bricking/analysis/lumen/lumen_values.h"
#include "bricking/analysis/lumen/voxel_set.h"

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

namespace tessera {

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

    /// Whether the voxel that the place lies in is lumen.
    bool holds(const glm::dvec3& mm) const { return voxels_.containsPlace(voxelOf(mm)); }
    /// How far a ray goes through voxels of the lumen, mm; `most` where it does not leave within that.
    /// @param direction  unit
    double rayMm(const glm::dvec3& mm, const glm::dvec3& direction, double most) const;
    /// What a quarter of the rays in all directions is shorter than, mm: about the radius of a tube.
    double roughRadiusMm(const glm::dvec3& mm) const;

    /// Distance to the wall, mm; 0 outside. To the nearest voxel's middle that is not lumen, exact for any
    /// affine, then back along that way to where the trilinear values cross the threshold. Within four voxels
    /// of the wall it is the least of this and of 42 rays to where they do.
    double wallMm(const glm::dvec3& mm, LumenValues& values, const LumenRule& rule) const;
    /// How much further than the rule's threshold a wall's own edge lies, mm. The edge is half way between
    /// the lumen's value and the furthest that the wall comes to. The result is the median over those of 42
    /// rays that meet the wall within 1.5 times wallMm; 0 where no two do.
    /// @param wallMm  of the place, by the same rule
    /// @param lumen  the lumen's value, physical units
    double edgeBeyondMm(const glm::dvec3& mm, double wallMm, LumenValues& values, const LumenRule& rule,
                        double lumen) const;
    /// Whether all of a straight line is lumen, by its voxels and by its trilinear values, looked at every
    /// quarter of a voxel.
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
