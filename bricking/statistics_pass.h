// bricking/statistics_pass.h: the two passes over a store's chunks that statistics come from. Internal to
// statistics.cpp; the results do not depend on the number of threads.
#pragma once

#include "bricking/statistics.h"
#include "bricking/store/buffer_pool.h"

#include <cstdint>
#include <functional>
#include <span>

namespace tessera {

/// Brick layers handled at once; also the z extent of a chunk of the stored histograms.
constexpr int kHistogramLayers = 4;

/// Fills cellMin, cellMax (sized already), lowest and highest from level 0.
/// @param pool  buffers of store.chunkBytes(), one per thread
void gatherCells(const StoreReader& store, Statistics& statistics, BufferPool& pool, int threads);

/// Fills brickMean (sized already) from the coarsest level.
void gatherMeans(const StoreReader& store, Statistics& statistics, BufferPool& pool);

/// Histograms of all bricks at one level, kHistogramLayers layers of bricks at a time.
/// @param counts  scratch for kHistogramLayers * bricks.y * bricks.x * kHistogramBins counts
/// @param done  called in order with the number of the group of layers and its counts, [z][y][x][bin]
void gatherHistograms(const StoreReader& store, int level, double lowest, double highest, BufferPool& pool,
                      std::span<std::uint16_t> counts, int threads,
                      const std::function<void(int, std::span<const std::uint16_t>)>& done);

} // namespace tessera
