// render/light/occlusion_of_meshes.cpp: meshes that take a volume's light (docs/sampling.md, "Voxelised
// meshes"): see occlusion.h.
#include "core/base/brick.h"
#include "render/light/occlusion.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vector_relational.hpp>

namespace tessera {
namespace {

/// Calls visit(voxel, thickness) for all that is set in a brick of bits.
template <typename Visit> void forEachSet(const MeshBits& bits, const glm::ivec3& brick, const Visit& visit) {
    const std::uint32_t* const words = bits.brickBits(brick);
    const std::uint8_t* const alphas = bits.brickAlphas(brick);
    const glm::ivec3 first = brick * MeshBits::kBrick;
    for (int row = 0; row < MeshBits::kBrick * MeshBits::kBrick; ++row) {
        const std::uint32_t word = words ? words[row] : 0;
        for (int x = 0; x < MeshBits::kBrick && (word != 0 || alphas); ++x) {
            const float thickness = (word >> x & 1) != 0 ? MeshBits::kOpaque
                                    : alphas ? MeshBits::thicknessOf(alphas[row * MeshBits::kBrick + x])
                                             : 0.0f;
            if (thickness > 0)
                visit(first + glm::ivec3(x, row % MeshBits::kBrick, row / MeshBits::kBrick), thickness);
        }
    }
}

/// Bricks of bits, whose level is another, that a chunk's samples lie in: from, and one past the last.
void bricksOf(const MeshBits& bits, const ChunkKey& chunk, int level, glm::ivec3& from, glm::ivec3& to) {
    const glm::ivec3 at(chunk.i, chunk.j, chunk.k);
    const int up = chunk.level - level;
    from = up >= 0 ? at << up : at >> -up;
    to = glm::min(up >= 0 ? (at + 1) << up : from + 1, bits.grid().bricks());
}

template <typename Visit>
void forEachBrick(const glm::ivec3& from, const glm::ivec3& to, const Visit& visit) {
    for (int z = from.z; z < to.z; ++z)
        for (int y = from.y; y < to.y; ++y)
            for (int x = from.x; x < to.x; ++x)
                visit(glm::ivec3(x, y, z));
}

} // namespace

MeshLattice meshLattice(const VolumeInfo& info, const Occlusion& occlusion,
                        std::span<const SceneMesh> meshes) {
    constexpr int kMostSamples = 1024; // along an axis
    constexpr std::size_t kMostBytes = std::size_t{64} << 20;
    MeshLattice lattice{{}, occlusionLevel(occlusion, info)};
    const glm::ivec3 n = info.extentVoxels;
    while (lattice.level + 1 < kLevelCount && std::max({n.x, n.y, n.z}) >> lattice.level > kMostSamples)
        ++lattice.level;
    const auto gridOf = [&](int level) {
        return gridOnLattice(info.patientFromVoxel, levelExtent(n, level), 1 << level);
    };
    lattice.grid = gridOf(lattice.level);
    while (lattice.level + 1 < kLevelCount && MeshBits::bytesAtMost(meshes, lattice.grid, false) > kMostBytes)
        lattice.grid = gridOf(++lattice.level);
    return lattice;
}

bool Occluder::meshesLetThrough(const ChunkKey& chunk) const {
    if (!meshes_)
        return true;
    glm::ivec3 from(0), to(0);
    bricksOf(*meshes_, chunk, meshLevel_, from, to);
    bool empty = true;
    forEachBrick(from, to, [&](const glm::ivec3& brick) {
        empty = empty && !meshes_->brickBits(brick) && !meshes_->brickAlphas(brick);
    });
    return empty;
}

/// The mean extinction of the bits that a sample stands for; of a finer level that of the bit around it.
void Occluder::addMeshes(const ChunkKey& key, float* extinction) const {
    glm::ivec3 from(0), to(0);
    bricksOf(*meshes_, key, meshLevel_, from, to);
    const int up = key.level - meshLevel_;
    const auto perMm = static_cast<float>(std::ldexp(1 / meshes_->grid().edgeMm, -3 * std::max(up, 0)));
    const glm::ivec3 first = glm::ivec3(key.i, key.j, key.k) * kChunkExtent, edge(kChunkExtent);
    forEachBrick(from, to, [&](const glm::ivec3& brick) {
        forEachSet(*meshes_, brick, [&](const glm::ivec3& voxel, float thickness) {
            if (up >= 0) {
                extinction[linearIndex((voxel >> up) - first, edge)] += perMm * thickness;
                return;
            }
            const glm::ivec3 low = glm::max((voxel << -up) - first, glm::ivec3(0)),
                             high = glm::min(((voxel + 1) << -up) - first, edge);
            forEachBrick(low, high, [&](const glm::ivec3& sample) {
                extinction[linearIndex(sample, edge)] += perMm * thickness;
            });
        });
    });
}

} // namespace tessera
