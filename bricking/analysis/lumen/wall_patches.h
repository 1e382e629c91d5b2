// bricking/analysis/lumen/wall_patches.h: a lumen's wall as faces of voxels, each with the wall's normal and
// the area that it represents. The faces of a lumen's wall, seen or not, and the patches of unseen faces.
#pragma once

#include "bricking/analysis/lumen/voxel_set.h"
#include "bricking/analysis/lumen/wall_coverage.h"

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
