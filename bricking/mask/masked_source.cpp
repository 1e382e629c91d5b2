// bricking/mask/masked_source.cpp: see masked_source.h.
#include "bricking/mask/masked_source.h"

#include "bricking/store/pyramid.h"
#include "core/base/error.h"
#include "core/base/threads.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <type_traits>
#include <utility>
#include <vector>

namespace tessera {
namespace {

constexpr glm::ivec3 kChunk(kChunkExtent);

/// Of a thread that reads: shares, and of the two levels above Mask::kExactLevel a box of the level below,
/// its means and a chunk.
std::size_t scratchBytes(std::size_t chunkBytes) {
    constexpr std::size_t kBoxes = 8, kLevels = kLevelCount - 1 - Mask::kExactLevel;
    return cellCount(kChunk) * sizeof(float) * (1 + kLevels) + kLevels * (kBoxes + 2) * chunkBytes;
}

template <typename Value> Value blended(Value value, float share, double air) {
    if (share <= 0)
        return value;
    const double mixed =
        static_cast<double>(value) + static_cast<double>(share) * (air - static_cast<double>(value));
    if constexpr (std::is_floating_point_v<Value>)
        return static_cast<Value>(mixed);
    else
        return static_cast<Value>(static_cast<std::int32_t>(mixed + (mixed < 0 ? -0.5 : 0.5)));
}

} // namespace

MaskedSource::MaskedSource(const ChunkSource& source, std::shared_ptr<const HiddenPart> mask,
                           double airStored, MemoryBudget& ram, int threads)
    : source_(source), mask_(std::move(mask)), air_(airStored),
      scratch_(ram.charge(static_cast<std::size_t>(threads > 0 ? threads : defaultThreads()) *
                              scratchBytes(source.chunkBytes()),
                          "hiding a part")) {
    TESSERA_CHECK(mask_);
}

void MaskedSource::readChunk(const ChunkKey& key, std::span<std::byte> out) const {
    const glm::ivec3 extent = levelExtent(info().extentVoxels, key.level);
    const glm::ivec3 first = glm::ivec3(key.i, key.j, key.k) * kChunkExtent;
    const glm::ivec3 count = glm::min(extent - first, kChunk);
    const HiddenPart::Part part =
        mask_->of(first << key.level, glm::min((first + count) << key.level, info().extentVoxels));
    if (part == Mask::Part::all && count == kChunk) { // nothing beyond the edge
        withValueType(info().type, [&](auto example) {
            using Value = decltype(example);
            std::fill_n(reinterpret_cast<Value*>(out.data()), cellCount(kChunk), static_cast<Value>(air_));
        });
        return;
    }
    source_.readChunk(key, out);
    if (part == Mask::Part::none)
        return;
    std::vector<float> shares(cellCount(count));
    mask_->read(key.level, first, count, shares);
    withValueType(info().type, [&](auto example) {
        using Value = decltype(example);
        auto* const values = reinterpret_cast<Value*>(out.data());
        const auto forRows = [&](const auto& take) {
            for (int z = 0; z < count.z; ++z)
                for (int y = 0; y < count.y; ++y)
                    take(values + linearIndex({0, y, z}, kChunk),
                         shares.data() + linearIndex({0, y, z}, count), glm::ivec3(0, y, z));
        };
        if (key.level <= Mask::kExactLevel) {
            forRows([&](Value* row, const float* share, const glm::ivec3&) {
                for (int x = 0; x < count.x; ++x)
                    row[x] = blended(row[x], share[x], air_);
            });
            return;
        }
        // The samples of the level below, hidden in part, in a box as large as theirs.
        const glm::ivec3 finer = levelExtent(info().extentVoxels, key.level - 1);
        const glm::ivec3 low = 2 * first, box = glm::min(finer - low, 2 * count);
        std::vector<Value> below(cellCount(box)), means(cellCount(count));
        std::vector<std::byte> chunk(out.size());
        const glm::ivec3 chunks = ceilDiv(box, kChunkExtent);
        for (std::size_t n = 0; n < cellCount(chunks); ++n) {
            const glm::ivec3 in = gridPosition(n, chunks) * kChunkExtent, size = glm::min(box - in, kChunk);
            const glm::ivec3 at = (low + in) / kChunkExtent;
            readChunk({key.level - 1, at.x, at.y, at.z}, chunk);
            for (int z = 0; z < size.z; ++z)
                for (int y = 0; y < size.y; ++y)
                    std::memcpy(below.data() + linearIndex(in + glm::ivec3(0, y, z), box),
                                chunk.data() + linearIndex({0, y, z}, kChunk) * sizeof(Value),
                                static_cast<std::size_t>(size.x) * sizeof(Value));
        }
        reduceByTwo(info().type, box, std::as_bytes(std::span(below)),
                    std::as_writable_bytes(std::span(means)), 1);
        forRows([&](Value* row, const float* share, const glm::ivec3& at) {
            const Value* const mean = means.data() + linearIndex(at, count);
            for (int x = 0; x < count.x; ++x)
                if (share[x] > 0)
                    row[x] = mean[x];
        });
    });
}

} // namespace tessera
