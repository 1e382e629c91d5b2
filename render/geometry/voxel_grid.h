// render/geometry/voxel_grid.h: VoxelGrid: where the voxels of voxelised meshes lie (docs/sampling.md,
// "Voxelised meshes"): in cubes around the meshes, or on a volume's lattice.
#pragma once

#include "core/scene/mesh.h"

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <span>

namespace tessera {

struct VoxelGrid {
    static constexpr int kBrick = 32; // voxels along a side of a brick

    glm::dmat4 fromPatient{1}; // to voxels; the centre of voxel i is i + 1/2
    glm::ivec3 extent{0};      // voxels
    double edgeMm = 1;         // of a voxel; of one that is no cube, that of a cube as large

    glm::ivec3 bricks() const { return (extent + (kBrick - 1)) / kBrick; }
};

/// Cubes, so many along the longest side of the box of the meshes, and two more at either end.
/// @param meshes  their shapes have been read
VoxelGrid gridAround(std::span<const SceneMesh> meshes, int resolution);
/// Of a lattice whose samples are `pitch` voxels of a volume apart.
VoxelGrid gridOnLattice(const glm::dmat4& patientFromVoxel, const glm::ivec3& samples, int pitch);

} // namespace tessera
