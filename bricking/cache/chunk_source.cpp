// bricking/cache/chunk_source.cpp: see chunk_source.h.
#include "bricking/cache/chunk_source.h"

#include "core/base/error.h"

#include <cstring>
#include <glm/common.hpp>
#include <vector>

namespace tessera {

void RechunkedSource::readChunk(const ChunkKey& key, std::span<std::byte> out) const {
    TESSERA_CHECK(out.size() == chunkBytes());
    const std::size_t bytes = bytesPerValue(info().type);
    const glm::ivec3 chunk(kChunkExtent), own = ownExtent(key.level);
    const glm::ivec3 first = glm::ivec3(key.i, key.j, key.k) * kChunkExtent;
    const glm::ivec3 end = glm::min(first + chunk, levelExtent(info().extentVoxels, key.level));
    std::vector<std::byte> values(cellCount(own) * bytes);
    if (end != first + chunk)
        for (std::size_t at = 0; at < out.size(); at += bytes)
            storeFill(info(), out.data() + at);
    const glm::ivec3 low = first / own, high = (end - 1) / own;
    for (int k = low.z; k <= high.z; ++k)
        for (int j = low.y; j <= high.y; ++j)
            for (int i = low.x; i <= high.x; ++i) {
                const glm::ivec3 origin = glm::ivec3(i, j, k) * own;
                readOwn(key.level, {i, j, k}, values);
                const glm::ivec3 from = glm::max(origin, first), to = glm::min(origin + own, end);
                const auto row = static_cast<std::size_t>(to.x - from.x) * bytes;
                for (int z = from.z; z < to.z; ++z)
                    for (int y = from.y; y < to.y; ++y)
                        std::memcpy(
                            out.data() + linearIndex(glm::ivec3(from.x, y, z) - first, chunk) * bytes,
                            values.data() + linearIndex(glm::ivec3(from.x, y, z) - origin, own) * bytes, row);
            }
}

} // namespace tessera
