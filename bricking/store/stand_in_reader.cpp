// bricking/store/stand_in_reader.cpp: see stand_in_reader.h.
#include "bricking/store/stand_in_reader.h"

#include "bricking/store/pyramid.h" // kMajorityRule
#include "bricking/store/shard.h"
#include "bricking/store/store_files.h"
#include "bricking/store/zarr_metadata.h"
#include "core/base/error.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <tuple>
#include <type_traits>

namespace tessera {
namespace {

constexpr int kBoxEdge = kChunkExtent / 2 + 2; // coarse samples under a chunk, one level up, and around it

/// Where the samples of a chunk lie between coarse ones, along an axis.
struct Places {
    std::array<int, kChunkExtent> low{}, high{}; // coarse samples, in the box
    std::array<float, kChunkExtent> share{};     // of high

    /// @param first  the coarse sample under the chunk's first one, in the box
    /// @param count  coarse samples of the box
    Places(int first, int count, int levels, bool nearest) {
        for (int x = 0; x < kChunkExtent; ++x) {
            const auto at = static_cast<std::size_t>(x);
            const float place = (static_cast<float>(x) + 0.5f) / static_cast<float>(1 << levels) - 0.5f;
            const int below = nearest ? x >> levels : static_cast<int>(std::floor(place));
            share[at] = nearest ? 0.0f : place - static_cast<float>(below);
            low[at] = std::clamp(first + below, 0, count - 1);
            high[at] = std::clamp(first + below + 1, 0, count - 1);
        }
    }
};

template <typename Value> Value rounded(float value) {
    if constexpr (std::is_floating_point_v<Value>)
        return value;
    else
        return static_cast<Value>(std::lrint(value));
}

/// Replaces a coarse chunk by the chunk `key`, which it covers.
template <typename Value>
void refine(const VolumeInfo& info, const ChunkKey& key, const ChunkKey& coarse, bool nearest,
            std::span<std::byte> chunk) {
    const int levels = coarse.level - key.level;
    const glm::ivec3 edge(kChunkExtent);
    const glm::ivec3 held = glm::min(levelExtent(info.extentVoxels, coarse.level) -
                                         glm::ivec3(coarse.i, coarse.j, coarse.k) * kChunkExtent,
                                     edge);
    // The coarse samples under the chunk, and one around where the coarse chunk has it.
    const glm::ivec3 own = (glm::ivec3(key.i, key.j, key.k) * kChunkExtent >> levels) -
                           glm::ivec3(coarse.i, coarse.j, coarse.k) * kChunkExtent;
    const glm::ivec3 first = glm::max(own - 1, glm::ivec3(0));
    const glm::ivec3 box = glm::min(own + (kChunkExtent >> levels) + 1, held) - first;
    std::array<float, std::size_t{kBoxEdge} * kBoxEdge * kBoxEdge> samples; // 23 KiB
    auto* const values = reinterpret_cast<Value*>(chunk.data());
    for (int z = 0; z < box.z; ++z)
        for (int y = 0; y < box.y; ++y)
            for (int x = 0; x < box.x; ++x)
                samples[linearIndex({x, y, z}, box)] =
                    static_cast<float>(values[linearIndex(first + glm::ivec3(x, y, z), edge)]);
    fillWith(info, chunk);
    const glm::ivec3 count = glm::min(
        levelExtent(info.extentVoxels, key.level) - glm::ivec3(key.i, key.j, key.k) * kChunkExtent, edge);
    const Places xs(own.x - first.x, box.x, levels, nearest), ys(own.y - first.y, box.y, levels, nearest),
        zs(own.z - first.z, box.z, levels, nearest);
    const auto between = [](float a, float b, float share) { return a + share * (b - a); };
    for (int z = 0; z < count.z; ++z)
        for (int y = 0; y < count.y; ++y) {
            const auto zAt = static_cast<std::size_t>(z), yAt = static_cast<std::size_t>(y);
            const auto row = [&](int cy, int cz) { return samples.data() + linearIndex({0, cy, cz}, box); };
            const float* const r00 = row(ys.low[yAt], zs.low[zAt]);
            const float* const r01 = row(ys.high[yAt], zs.low[zAt]);
            const float* const r10 = row(ys.low[yAt], zs.high[zAt]);
            const float* const r11 = row(ys.high[yAt], zs.high[zAt]);
            Value* const to = values + linearIndex({0, y, z}, edge);
            for (int x = 0; x < count.x; ++x) {
                const auto xAt = static_cast<std::size_t>(x);
                const int a = xs.low[xAt], b = xs.high[xAt];
                const float share = xs.share[xAt];
                const float low =
                    between(between(r00[a], r00[b], share), between(r01[a], r01[b], share), ys.share[yAt]);
                const float high =
                    between(between(r10[a], r10[b], share), between(r11[a], r11[b], share), ys.share[yAt]);
                to[x] = rounded<Value>(between(low, high, zs.share[zAt]));
            }
        }
}

} // namespace

StandInReader::StandInReader(const std::filesystem::path& path, MemoryBudget& ram, const glm::dmat4& moved)
    : StoreReader(path, ram, moved) {
    const auto text = readText(openFolder(path), "zarr.json", path, kMaxMetadataBytes);
    areNames_ = parseGroup(text.value_or(""), (path / "zarr.json").string()).rule == kMajorityRule;
}

void StandInReader::readChunk(const ChunkKey& key, std::span<std::byte> out) const {
    try {
        return StoreReader::readChunk(key, out);
    } catch (const InputError& problem) {
        for (int level = key.level + 1; level < kLevelCount; ++level) {
            const int levels = level - key.level;
            const ChunkKey coarse{level, key.i >> levels, key.j >> levels, key.k >> levels};
            try {
                StoreReader::readChunk(coarse, out);
            } catch (const InputError&) {
                continue;
            }
            withValueType(info().type, [&](auto example) {
                refine<decltype(example)>(info(), key, coarse, areNames_, out);
            });
            return note(key, level, problem.what());
        }
        throw;
    }
}

void StandInReader::note(const ChunkKey& key, int drawnFrom, const char* why) const {
    const glm::ivec3 grid = chunkGrid(info().extentVoxels, key.level);
    const std::lock_guard lock(mutex_);
    std::vector<bool>& noted = noted_[static_cast<std::size_t>(key.level)];
    noted.resize(cellCount(grid));
    const std::size_t at = linearIndex({key.i, key.j, key.k}, grid);
    if (noted[at])
        return;
    noted[at] = true;
    ++count_;
    if (damaged_.size() < kMostNamed)
        damaged_.push_back({key, drawnFrom, why});
}

std::uint64_t StandInReader::damagedCount() const {
    const std::lock_guard lock(mutex_);
    return count_;
}

std::vector<DamagedChunk> StandInReader::damaged() const {
    std::vector<DamagedChunk> all;
    {
        const std::lock_guard lock(mutex_);
        all = damaged_;
    }
    std::sort(all.begin(), all.end(), [](const DamagedChunk& a, const DamagedChunk& b) {
        return std::tie(a.key.level, a.key.k, a.key.j, a.key.i) <
               std::tie(b.key.level, b.key.k, b.key.j, b.key.i);
    });
    return all;
}

bool hasStandIns(const StoreReader& store) {
    const auto* const reader = dynamic_cast<const StandInReader*>(&store);
    return reader && reader->damagedCount() > 0;
}

} // namespace tessera
