// render/residency/each_chunk.h: visits many chunks through the cache, in batches that it can pin.
#pragma once

#include "bricking/cache/brick_cache.h"

#include <algorithm>
#include <span>
#include <vector>

namespace tessera {

/// Visits chunks in batches that the cache can pin while others are decoded, until visit returns false.
template <typename Visit>
void forEachChunk(BrickCache& cache, const std::vector<ChunkKey>& keys, const Visit& visit) {
    const std::size_t batch = std::max<std::size_t>(1, cache.pinnableChunks() / 2);
    for (std::size_t first = 0; first < keys.size(); first += batch) {
        const std::size_t count = std::min(batch, keys.size() - first);
        auto futures = cache.request(std::span(keys).subspan(first, count));
        for (std::size_t i = 0; i < count; ++i) {
            if (!visit(keys[first + i], *futures[i].get()))
                return;
            futures[i] = {}; // unpin
        }
    }
}

} // namespace tessera
