// bricking/statistics/statistics_pass.h: the passes over a store's chunks that compute its statistics.
// Internal to statistics.cpp; the results do not depend on the number of threads.
#pragma once

#include "bricking/statistics/brick_rays.h"
#include "bricking/statistics/gathered_ranges.h"
#include "bricking/statistics/statistics.h"
#include "bricking/store/buffer_pool.h"

#include <array>
#include <cstdint>
#include <functional>
#include <limits>

namespace tessera {

/// Brick layers whose rays are sampled at once; also the z extent of a chunk of the stored rays.
constexpr int kRayLayers = 2;

/// Fills cellMin, cellMax, wideMin, wideMax (sized already), lowest and highest from level 0.
/// @param pool  buffers of store.chunkBytes(), one per thread
void gatherCells(const StoreReader& store, Statistics& statistics, BufferPool& pool, int threads);

/// Of values.
struct FoundRange {
    float lowest = std::numeric_limits<float>::infinity(), highest = -lowest;
    bool operator==(const FoundRange&) const = default;
};

/// Fills brickMean (sized already) from the coarsest level.
void gatherMeans(const ChunkSource& volume, Statistics& statistics, BufferPool& pool);

/// The whole volume's range and histogram (kHistogramBins).
struct WholeRange {
    float lowest = 0, highest = 0;
    std::vector<std::uint64_t> histogram;
};
/// Adds every voxel to the histogram; lowest and highest must be known.
void gatherHistogram(const StoreReader& store, WholeRange& whole, BufferPool& pool, int threads);

/// What a pass over all bricks gathers besides their rays.
struct WholePass {
    WholeRange& range; // lowest and highest: what the histogram takes for the range
    GatheredRanges &cells, &wide;
};

/// Memory of gatherRays without its pool.
std::size_t rayScratchBytes(const VolumeInfo& info, int threads);
/// The part of it for threads' fields.
std::size_t fieldBytes(int threads);
/// Rows of bricks of the bands that gatherRays() makes with so much memory.
int rayBandRows(const VolumeInfo& info, std::size_t freeBytes);

using BrickRaysDone = std::function<void(std::size_t, const std::array<BrickRayPart, kBrickRayParts>&)>;

/// Samples the rays of all bricks for which wanted() is true, kRayLayers layers of bricks at a time, or a
/// band of their rows of bricks if ram is scarce.
/// @param whole  if not null: gathered in the same pass, over all bricks
/// @param bandRows  rayBandRows(), or fewer
/// @param brickDone  called from any thread with a brick's position and its rays
/// @param groupDone  called in order, after the last brick of each group of layers
/// @return the range that `whole` has indeed
FoundRange gatherRays(const ChunkSource& volume, WholePass* whole, BufferPool& pool, MemoryBudget& ram,
                      int bandRows, int threads, const std::function<bool(std::size_t)>& wanted,
                      const BrickRaysDone& brickDone, const std::function<void(int)>& groupDone);

} // namespace tessera
