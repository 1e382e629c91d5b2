// bricking/analysis/body/body_voxels.h: sets of voxels of one level of a CT: what is dense, and what of it is
// the body. Internal to this room.
#pragma once

#include "bricking/analysis/body/marks.h"
#include "bricking/cache/chunk_source.h"
#include "core/base/brick.h"

#include <cstddef>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace tessera {

/// The finest level of at most so many samples, or the coarsest.
int bodyLevelOf(const VolumeInfo& info, std::size_t mostSamples);

/// A level's grid.
struct BodyGrid {
    glm::ivec3 extent;
    glm::dvec3 spacingMm;
    int threads; // that work on it; they change no result
    BodyGrid(const VolumeInfo& info, int level, int useThreads)
        : extent(levelExtent(info.extentVoxels, level)),
          spacingMm(static_cast<double>(1 << level) * info.spacingMm()), threads(useThreads) {}
    std::size_t size() const { return cellCount(extent); }
};

/// Memory that the search of a body and of its table takes at most.
/// @param type  of the level's chunks, which are read before most of it is needed
std::size_t bodyBytes(const glm::ivec3& levelExtent, ValueType type);

/// Of each of these values, in HU, ascending, the samples of a level that are above it.
std::vector<Marks> samplesAbove(std::span<const double> hu, const ChunkSource& source, int level,
                                const BodyGrid& grid);
/// The body among all voxels above kBodyHu (body_box.h).
struct BodyMarks {
    Marks marks;
    double ballMm = 0; // radius of the opening: parts thinner than its diameter may be missing
};
BodyMarks bodyAmong(const Marks& dense, const BodyGrid& grid);

} // namespace tessera
