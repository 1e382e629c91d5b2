// render/geometry/mesh_bits.h: MeshBits: the surfaces of meshes as a bit a voxel, in bricks of 32^3 where
// there is something (docs/sampling.md, "Voxelised meshes"; Papaioannou, Menexi and Papadopoulos 2010,
// "Real-Time Volume-Based Ambient Occlusion", 4). Translucent meshes are alphas of 8 bits beside them.
#pragma once

#include "core/base/budget.h"
#include "render/geometry/voxel_grid.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace tessera {

class MeshBits {
  public:
    static constexpr int kBrick = VoxelGrid::kBrick;
    static constexpr int kBlock = 4; // voxels along a side of what distances are counted in
    /// The extinction of an opaque surface, times the edge of a voxel: a voxel leaves 2^-12 of the light.
    static constexpr float kOpaque = 8.3177662f;

    /// @param meshes  their shapes have been read; those of opacity below 1 are alphas
    /// @param ram  charged before each allocation; null: the caller has charged bytesAtMost()
    /// @param threads  0: all processors; the result is the same
    /// @param distances  the caller asks clearVoxels()
    MeshBits(std::span<const SceneMesh> meshes, const VoxelGrid& grid, MemoryBudget* ram, int threads,
             bool distances);

    const VoxelGrid& grid() const { return grid_; }
    /// Of a voxel of the grid: a surface is there. Nothing is outside of the grid.
    bool isSet(const glm::ivec3& voxel) const;
    /// The largest alpha of the translucent surfaces there, in 1/255.
    std::uint8_t alphaOf(const glm::ivec3& voxel) const;

    /// V: the bits between the eight centres around a place, 0 to 1 (trilinear).
    float coverage(const glm::vec3& place) const;
    /// The extinction of translucent surfaces there, times the edge of a voxel: -log(1 - alpha), trilinear.
    float thickness(const glm::vec3& place) const;
    bool hasAlphas() const { return !alphas_.empty(); }
    /// Around a place: how many voxels away along any axis all is 0; not above 0 near a surface.
    int clearVoxels(const glm::vec3& place) const;

    /// Words of 32 voxels along x of a brick: at [32 z + y]; null: nothing is set.
    const std::uint32_t* brickBits(const glm::ivec3& brick) const;
    /// x fastest; null: nothing.
    const std::uint8_t* brickAlphas(const glm::ivec3& brick) const;
    /// Of an alpha: -log(1 - alpha), at most kOpaque.
    static float thicknessOf(std::uint8_t alpha);

    /// Voxels that are set, and RAM.
    std::size_t count() const;
    std::size_t bytes() const { return bytes_; }
    /// RAM, before anything is known but the boxes of the meshes.
    static std::size_t bytesAtMost(std::span<const SceneMesh> meshes, const VoxelGrid& grid, bool distances);

  private:
    using Words = std::array<std::uint32_t, std::size_t{kBrick} * kBrick>;
    using Alphas = std::array<std::uint8_t, std::size_t{kBrick} * kBrick * kBrick>;
    std::size_t brickIndex(const glm::ivec3& brick) const;
    class Maker;
    void findDistances();

    VoxelGrid grid_;
    glm::ivec3 bricks_, blocks_;
    std::vector<std::unique_ptr<Words>> words_;   // of the bricks, x fastest; null: empty
    std::vector<std::unique_ptr<Alphas>> alphas_; // the same; none: no mesh is translucent
    std::vector<std::uint8_t> distances_;         // of blocks, to the nearest one with something
    std::size_t bytes_ = 0;
    std::vector<Charge> charges_;
};

} // namespace tessera
