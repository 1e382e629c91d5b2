// bricking/analysis/body/body_voxels.h: sets of voxels of one level of a CT: what is dense, and what of it is
// the body. Internal to this room.
#pragma once

#include "bricking/cache/chunk_source.h"
#include "core/base/brick.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace tessera {

/// The finest level of at most so many samples, or the coarsest.
int bodyLevelOf(const VolumeInfo& info, std::size_t mostSamples);

/// A level's grid, and sets of its voxels as bytes.
struct BodyGrid {
    glm::ivec3 extent;
    glm::dvec3 spacingMm;
    int threads; // that work on it; they change no result
    BodyGrid(const VolumeInfo& info, int level, int useThreads)
        : extent(levelExtent(info.extentVoxels, level)),
          spacingMm(static_cast<double>(1 << level) * info.spacingMm()), threads(useThreads) {}
    std::size_t size() const { return cellCount(extent); }
    /// Calls what(index) for the up to six voxels that share a face.
    template <typename What> void beside(std::size_t index, const What& what) const {
        const glm::ivec3 at = gridPosition(index, extent);
        for (int face = 0; face < 6; ++face) {
            glm::ivec3 next = at;
            next[face / 2] += face % 2 == 0 ? -1 : 1;
            if (next[face / 2] >= 0 && next[face / 2] < extent[face / 2])
                what(linearIndex(next, extent));
        }
    }
};
using Marks = std::vector<std::uint8_t>;

/// Bytes per sample that the functions below take at most together: two distance fields, the voxels of a
/// part, which grow by doubling, and seven sets of marks.
constexpr std::size_t kBodyBytesPerSample = 2 * sizeof(float) + 2 * sizeof(std::int32_t) + 8;

/// Of each sample of a level, the number of these values, in HU, that it is above.
Marks samplesAbove(std::span<const double> hu, const ChunkSource& source, int level, const BodyGrid& grid);
/// Calls part(voxels) for every connected part of the marked voxels; by faces, in the order of their first
/// voxels. `part` may change marks of its voxels only.
void forParts(const Marks& marks, const BodyGrid& grid,
              const std::function<void(std::span<const std::int32_t>)>& part);
/// Squared distance to the nearest voxel with mark `of`, mm2.
std::vector<float> distancesTo(const Marks& marks, std::uint8_t of, const BodyGrid& grid);
/// The marks of the body among those of all voxels above kBodyHu (body_box.h).
struct BodyMarks {
    Marks marks;
    double ballMm = 0; // radius of the opening: parts thinner than its diameter may be missing
};
BodyMarks bodyAmong(const Marks& dense, const BodyGrid& grid);

} // namespace tessera
