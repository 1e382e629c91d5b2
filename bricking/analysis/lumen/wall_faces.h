// bricking/analysis/lumen/wall_faces.h: a lumen's wall as faces of voxels, each with the wall's normal and
// the area that it represents.
#pragma once

#include "bricking/analysis/lumen/voxel_set.h"

#include <array>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <vector>

namespace tessera {

/// Sides of a voxel: -x +x -y +y -z +z.
constexpr int kSides = 6;
inline glm::ivec3 sideStep(int side) {
    glm::ivec3 step(0);
    step[side >> 1] = side & 1 ? 1 : -1;
    return step;
}

class WallFaces {
  public:
    /// The set must outlive it.
    WallFaces(const VoxelSet& voxels, const glm::dmat4& patientFromVoxel);

    /// Voxels of a row of a chunk with wall at a side, as bits; the volume's border is no wall.
    std::uint32_t bits(const glm::ivec3& chunk, int row, int side) const;

    struct Face {
        glm::dvec3 middle{0};  ///< voxel space
        glm::dvec3 outward{0}; ///< the wall's normal, patient space, unit
        double areaMm2 = 0;    ///< of the wall, 0 or more
        glm::dvec3 above{0};   ///< voxel space: half a voxel above the wall, in the lumen
    };
    Face at(const glm::ivec3& voxel, int side) const;

  private:
    const VoxelSet& voxels_;
    glm::dmat3 voxelFromMm_, covector_; // from a covector of voxel space to one of patient space
    double voxelMm3_;
    struct Neighbour {
        glm::ivec3 offset; // from the face's voxel
        glm::dvec3 moment; // about the face, weighted
    };
    std::array<std::vector<Neighbour>, kSides> around_;
};

/// True if a straight line, ends included, passes only through voxels of the set. Voxel space.
bool seesThrough(const VoxelSet& voxels, const glm::dvec3& from, const glm::dvec3& to);

} // namespace tessera
