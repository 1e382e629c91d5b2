// bricking/analysis/lumen/lumen_values.cpp: see lumen_values.h.
#include "bricking/analysis/lumen/lumen_values.h"

#include <algorithm>
#include <glm/common.hpp>

namespace tessera {

double LumenValues::voxel(const glm::ivec3& voxel) {
    const glm::ivec3 chunk = voxel >> 5, local = voxel & 31;
    Held& held = held_[static_cast<std::size_t>((chunk.x & 1) + 2 * (chunk.y & 1) + 4 * (chunk.z & 1))];
    if (held.chunk != chunk) {
        held.values.reset(); // first, so that never more than eight are held
        held.values = cache_.get({0, chunk.x, chunk.y, chunk.z});
        held.chunk = chunk;
    }
    const std::size_t at = linearIndex(local, glm::ivec3(kChunkExtent)) * bytesPerValue(info_.type);
    return info_.rescaleSlope * storedValue(info_.type, held.values->bytes.get() + at) +
           info_.rescaleIntercept;
}

double LumenValues::at(const glm::dvec3& place) {
    const glm::dvec3 last(info_.extentVoxels - 1);
    const glm::dvec3 p = glm::clamp(place - 0.5, glm::dvec3(0), last);
    const glm::ivec3 low = glm::min(glm::ivec3(p), glm::max(info_.extentVoxels - 2, glm::ivec3(0)));
    const glm::ivec3 high = glm::min(low + 1, info_.extentVoxels - 1);
    const glm::dvec3 t = p - glm::dvec3(low);
    const auto alongX = [&](int y, int z) {
        return voxel({low.x, y, z}) * (1 - t.x) + voxel({high.x, y, z}) * t.x;
    };
    const auto alongY = [&](int z) { return alongX(low.y, z) * (1 - t.y) + alongX(high.y, z) * t.y; };
    return alongY(low.z) * (1 - t.z) + alongY(high.z) * t.z;
}

bool LumenValues::inside(const glm::dvec3& place, const LumenRule& rule) {
    const glm::dvec3 n(info_.extentVoxels);
    for (int axis = 0; axis < 3; ++axis)
        if (!(place[axis] >= 0 && place[axis] <= n[axis]))
            return false;
    return rule.takes(at(place));
}

void chunkBits(const Chunk& chunk, const VolumeInfo& info, const glm::ivec3& at, const LumenRule& rule,
               ChunkRows& rows) {
    const glm::ivec3 n = glm::min(info.extentVoxels - kChunkExtent * at, glm::ivec3(kChunkExtent));
    const std::uint32_t wide = n.x >= kChunkExtent ? ~0u : (1u << n.x) - 1;
    // of stored values: depth > 0 as low < factor * stored < high
    const double factor = rule.below ? -info.rescaleSlope : info.rescaleSlope;
    const double sign = rule.below ? -1 : 1;
    const double low = sign * (rule.threshold - info.rescaleIntercept);
    const double high =
        rule.below ? std::numeric_limits<double>::infinity() : rule.brightest - info.rescaleIntercept;
    withValueType(info.type, [&](auto typed) {
        using Value = decltype(typed);
        std::array<Value, kChunkExtent> values;
        for (int z = 0; z < kChunkExtent; ++z)
            for (int y = 0; y < kChunkExtent; ++y) {
                std::uint32_t& row = rows[static_cast<std::size_t>(y + kChunkExtent * z)];
                row = 0;
                if (y >= n.y || z >= n.z)
                    continue;
                std::memcpy(values.data(),
                            chunk.bytes.get() +
                                static_cast<std::size_t>(y + kChunkExtent * z) * sizeof values,
                            sizeof values);
                for (unsigned x = 0; x < kChunkExtent; ++x) {
                    const double value = factor * static_cast<double>(values[x]);
                    row |= static_cast<std::uint32_t>(value > low && value < high) << x;
                }
                row &= wide;
            }
    });
}

} // namespace tessera
