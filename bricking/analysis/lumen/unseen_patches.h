// bricking/analysis/lumen/unseen_patches.h: the faces of a lumen's wall, seen or not, and the patches of
// unseen faces.
#pragma once

#include "bricking/analysis/lumen/voxel_set.h"
#include "bricking/analysis/lumen/wall_coverage.h"

#include <glm/mat4x4.hpp>

namespace tessera {

/// A face of a voxel between lumen and wall.
struct CoverageFace {
    static constexpr std::uint32_t kSeen = 1u << 31;
    std::uint32_t place = 0; ///< in its chunk: voxel x + 32 y + 1024 z, times 8, and side; kSeen
    float areaMm2 = 0, alongMm = 0;
    bool seen() const { return place & kSeen; }
    static std::uint32_t placeOf(const glm::ivec3& voxel, int side) {
        return static_cast<std::uint32_t>(((voxel.x & 31) + 32 * (voxel.y & 31) + 1024 * (voxel.z & 31)) * 8 +
                                          side);
    }
};

/// Faces by chunk, in order of position.
struct ChunkFaces {
    Charge charge;
    std::vector<std::size_t> chunks; ///< ascending
    std::vector<std::size_t> first;  ///< of each chunk's faces; one more: the end
    std::vector<CoverageFace> all;
};

/// Largest first. Throws InputError naming the budget's option if its tables do not fit.
std::vector<UnseenPatch> unseenPatches(const ChunkFaces& faces, const VoxelSet& voxels,
                                       const glm::dmat4& patientFromVoxel, double smallestMm2,
                                       MemoryBudget& ram);

} // namespace tessera
