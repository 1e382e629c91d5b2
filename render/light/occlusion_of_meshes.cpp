// render/light/occlusion_of_meshes.cpp: meshes that take a volume's light (docs/sampling.md, "Voxelised
// meshes"): see occlusion.h.
#include "core/base/brick.h"
#include "render/light/occlusion.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
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

/// Of places from one to before another.
template <typename Visit>
void forEachBrick(const glm::ivec3& from, const glm::ivec3& to, const Visit& visit) {
    for (int z = from.z; z < to.z; ++z)
        for (int y = from.y; y < to.y; ++y)
            for (int x = from.x; x < to.x; ++x)
                visit(glm::ivec3(x, y, z));
}

/// How thick a surface in a voxel is across it: the distance of the lattice's layers along the axis that it
/// is steepest to, where fewest voxels around are set.
class Thickness {
  public:
    explicit Thickness(const MeshBits& bits) : bits_(bits) {
        const glm::dmat3 voxels = glm::transpose(glm::dmat3(bits.grid().fromPatient));
        for (int axis = 0; axis < 3; ++axis)
            mm_[axis] = static_cast<float>(1 / glm::length(voxels[axis]));
        const auto [least, most] = std::minmax({mm_.x, mm_.y, mm_.z});
        even_ = most < least * 1.01f;
    }
    float of(const glm::ivec3& voxel) const {
        if (even_)
            return static_cast<float>(bits_.grid().edgeMm);
        glm::ivec3 set(0); // voxels around, by axes along which they lie aside
        forEachBrick(glm::ivec3(-1), glm::ivec3(2), [&](const glm::ivec3& aside) {
            if (bits_.isSet(voxel + aside) || bits_.alphaOf(voxel + aside) != 0)
                set += glm::abs(aside);
        });
        int across = 0;
        for (int axis = 1; axis < 3; ++axis)
            if (set[axis] < set[across])
                across = axis;
        return mm_[across];
    }

  private:
    const MeshBits& bits_;
    glm::vec3 mm_{0};
    bool even_ = true;
};

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

void Occluder::setMeshes(const MeshBits* bits, int level) {
    meshes_ = bits;
    meshLevel_ = level;
}

/// The mean extinction of the bits that a sample stands for; of a finer level that of the bit around it.
void Occluder::readMeshes(const ChunkKey& chunk, OcclusionRoom& room) const {
    const int up = chunk.level - meshLevel_, down = std::max(-up, 0);
    const Thickness thicknessMm(*meshes_);
    const glm::ivec3 first = glm::ivec3(chunk.i, chunk.j, chunk.k) * kChunkExtent - room.reach,
                     low = glm::max(first, glm::ivec3(0)),
                     high = glm::min(first + 2 * room.reach + kChunkExtent,
                                     levelExtent(info_.extentVoxels, chunk.level));
    const auto add = [&](const glm::ivec3& sample, float extinction) {
        const glm::ivec3 at = sample - first;
        room.ofMeshes[linearIndex(at, room.size)] += extinction;
        room.rowShows[static_cast<std::size_t>(at.z * room.size.y + at.y)] = 1;
    };
    const glm::ivec3 from = up >= 0 ? low << up : low >> down,
                     last = up >= 0 ? (high << up) - 1 : (high - 1) >> down;
    const glm::ivec3 end = glm::min(last / MeshBits::kBrick + 1, meshes_->grid().bricks());
    forEachBrick(from / MeshBits::kBrick, end, [&](const glm::ivec3& brick) {
        forEachSet(*meshes_, brick, [&](const glm::ivec3& voxel, float depth) {
            if (glm::any(glm::lessThan(voxel, from)) || glm::any(glm::greaterThan(voxel, last)))
                return;
            const float extinction = depth / thicknessMm.of(voxel);
            if (up >= 0)
                return add(voxel >> up, std::ldexp(extinction, -3 * up));
            forEachBrick(glm::max(voxel << down, low), glm::min((voxel + 1) << down, high),
                         [&](const glm::ivec3& sample) { add(sample, extinction); });
        });
    });
    const auto layer = static_cast<std::ptrdiff_t>(cellCount({room.size.x, room.size.y, 1}));
    for (std::vector<float>& sent : room.emission)
        if (!sent.empty())
            std::copy_n(sent.begin() + room.reach.z * layer, kChunkExtent * layer,
                        sent.begin() + static_cast<std::ptrdiff_t>(room.extinction.size()));
}

} // namespace tessera
