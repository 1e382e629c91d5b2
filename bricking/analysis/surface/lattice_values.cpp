// bricking/analysis/surface/lattice_values.cpp: see lattice_values.h.
#include "bricking/analysis/surface/lattice_values.h"

#include <algorithm>
#include <cstring>
#include <glm/common.hpp>

namespace tessera {

const std::byte* LatticeValues::chunkOf(const glm::ivec3& chunk) {
    Held& held = held_[static_cast<std::size_t>((chunk.x & 1) + 2 * (chunk.y & 1) + 4 * (chunk.z & 1))];
    if (held.chunk != chunk) {
        held.values.reset(); // first, so that never more than eight are held
        held.chunk = glm::ivec3(-1);
        held.values = cache_.get({lattice_.level(), chunk.x, chunk.y, chunk.z});
        held.chunk = chunk;
    }
    return held.values->bytes.get();
}

void LatticeValues::readSamples(const glm::ivec3& low, const glm::ivec3& high) {
    const glm::ivec3 count = high - low + 1, firstChunk = low / kChunkExtent, lastChunk = high / kChunkExtent;
    samples_.resize(cellCount(count));
    withValueType(info_.type, [&](auto typed) {
        using Value = decltype(typed);
        for (int k = firstChunk.z; k <= lastChunk.z; ++k)
            for (int j = firstChunk.y; j <= lastChunk.y; ++j)
                for (int i = firstChunk.x; i <= lastChunk.x; ++i) {
                    const glm::ivec3 corner = kChunkExtent * glm::ivec3(i, j, k);
                    const glm::ivec3 from = glm::max(low, corner),
                                     to = glm::min(high, corner + (kChunkExtent - 1));
                    const std::byte* const chunk = chunkOf({i, j, k});
                    for (int z = from.z; z <= to.z; ++z)
                        for (int y = from.y; y <= to.y; ++y) {
                            const std::byte* at =
                                chunk + sizeof(Value) * linearIndex(glm::ivec3(from.x, y, z) - corner,
                                                                    glm::ivec3(kChunkExtent));
                            double* out =
                                samples_.data() + linearIndex(glm::ivec3(from.x, y, z) - low, count);
                            for (int x = from.x; x <= to.x; ++x, at += sizeof(Value)) {
                                Value stored;
                                std::memcpy(&stored, at, sizeof stored);
                                *out++ = of(static_cast<double>(stored));
                            }
                        }
                }
    });
}

void LatticeValues::read(const glm::ivec3& low, const glm::ivec3& high, std::vector<double>& out) {
    glm::ivec3 first(0), last(0);
    bool plain = true; // every plane is one of samples, and none is outside
    for (int axis = 0; axis < 3; ++axis) {
        const auto& planes = lattice_.planes(axis);
        first[axis] = planes[static_cast<std::size_t>(low[axis])].low;
        last[axis] = planes[static_cast<std::size_t>(high[axis])].high;
        plain = plain && low[axis] >= 2 && high[axis] + 2 < static_cast<int>(planes.size());
    }
    readSamples(first, last);
    if (plain) {
        out.swap(samples_);
        return;
    }
    const glm::ivec3 count = last - first + 1;
    out.clear();
    out.reserve(cellCount(high - low + 1));
    for (int z = low.z; z <= high.z; ++z)
        for (int y = low.y; y <= high.y; ++y)
            for (int x = low.x; x <= high.x; ++x) {
                if (lattice_.isOutside(0, x) || lattice_.isOutside(1, y) || lattice_.isOutside(2, z)) {
                    out.push_back(kOutside);
                    continue;
                }
                const LatticePlane& px = lattice_.planes(0)[static_cast<std::size_t>(x)];
                const LatticePlane& py = lattice_.planes(1)[static_cast<std::size_t>(y)];
                const LatticePlane& pz = lattice_.planes(2)[static_cast<std::size_t>(z)];
                const auto blend = [](double a, double b, double weight) { return a + weight * (b - a); };
                const auto sample = [&](int i, int j, int k) {
                    return samples_[linearIndex(glm::ivec3(i, j, k) - first, count)];
                };
                const auto alongX = [&](int j, int k) {
                    return blend(sample(px.low, j, k), sample(px.high, j, k), px.weight);
                };
                const auto alongY = [&](int k) {
                    return blend(alongX(py.low, k), alongX(py.high, k), py.weight);
                };
                out.push_back(blend(alongY(pz.low), alongY(pz.high), pz.weight));
            }
}

} // namespace tessera
