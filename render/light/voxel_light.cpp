// render/light/voxel_light.cpp: see voxel_light.h.
#include "render/light/voxel_light.h"

#include "core/brick.h"
#include "core/error.h"
#include "core/threads.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <set>

namespace tessera {
namespace {

constexpr std::size_t kChunkTexels = std::size_t{kChunkExtent} * kChunkExtent * kChunkExtent;
constexpr std::size_t kChunksAtATime = 32, kBricksAtATime = 32;
constexpr std::size_t kLeastChunks = 128; // kept for those beside them

/// A curve through chunks whose neighbours along it are neighbours in space.
std::uint64_t mortonOf(const ChunkKey& key) {
    std::uint64_t code = 0;
    for (int bit = 0; bit < 20; ++bit)
        code |= static_cast<std::uint64_t>(((key.i >> bit) & 1) | ((key.j >> bit) & 1) << 1 |
                                           ((key.k >> bit) & 1) << 2)
                << (3 * bit);
    return code;
}

glm::ivec3 placeOf(const ChunkKey& key) {
    return {key.i, key.j, key.k};
}
ChunkKey chunkHolding(const glm::ivec3& sample, int level) {
    const glm::ivec3 at = sample >> 5;
    return {level, at.x, at.y, at.z};
}

} // namespace

std::uint16_t lightTexel(float light) {
    return static_cast<std::uint16_t>(std::clamp(std::lround(light * leaf::kLightOne), 0L, 65535L));
}

VoxelLight::VoxelLight(const VolumeInfo& info, const Statistics& statistics, const Lighting& lighting,
                       std::span<const ShadowMaps> shadows, int threads)
    : info_(info), shadows_(shadows), occlusion_(lighting.occlusion),
      threads_(threads > 0 ? threads : defaultThreads()), channels_(lightChannels(lighting)),
      occluder_(info, statistics, lighting.occlusion),
      finest_(std::max(occluder_.finestLevel(), std::clamp(lighting.finestLevel, 0, kLevelCount - 1))) {
    TESSERA_CHECK(channels_ <= leaf::kMostLightChannels);
    TESSERA_CHECK(channels_ == static_cast<int>(shadows.size()) + ambientChannels(lighting));
}

std::size_t VoxelLight::bytes(const VolumeInfo& info, const Lighting& lighting, int threads) {
    const int used = threads > 0 ? threads : defaultThreads();
    glm::ivec3 reach(0);
    if (lighting.occlusion)
        for (int level = occlusionLevel(*lighting.occlusion, info); level < kLevelCount; ++level)
            reach = glm::max(reach, occlusionRays(*lighting.occlusion, info, level).reach);
    return static_cast<std::size_t>(used) * OcclusionRoom::bytes(reach, ambientChannels(lighting) > 1) +
           2 * kLeastChunks * kChunkTexels * sizeof(std::uint16_t) *
               static_cast<std::size_t>(lightChannels(lighting));
}

void VoxelLight::functionChanged(const TransferTable& table, const Optics& optics) {
    occluder_.setFunction(table, optics);
    chunks_.clear();
}

void VoxelLight::light(const ChunkKey& key, LitChunk& chunk, BrickCache& cache, OcclusionRoom& room) const {
    chunk.texels.clear();
    const std::span<const std::uint8_t> all;
    occluder_.find(key, chunk.isWhole ? all : chunk.bricks, cache, room);
    if (room.runs.empty())
        return; // nothing shows: no texel will be looked at
    chunk.texels.assign(kChunkTexels * static_cast<std::size_t>(channels_), lightTexel(1));
    std::uint16_t* to = chunk.texels.data();
    if (occlusion_) {
        occluder_.occlude(key, room);
        const auto bias = static_cast<float>(occlusion_->bias), gamma = static_cast<float>(occlusion_->gamma);
        const std::size_t colours = occluder_.gathersEmission() ? 3 : 1;
        for (std::size_t c = 0; c < colours; ++c, to += kChunkTexels)
            for (const OcclusionRoom::Run& run : room.runs)
                for (std::size_t n = run.to; n < run.to + native::kOcclusionRun; ++n)
                    to[n] = lightTexel(
                        std::pow(bias + room.light[n] + (colours > 1 ? room.shine[c][n] : 0.0f), gamma));
    }
    const double voxels = std::ldexp(1, key.level);
    for (const ShadowMaps& shadow : shadows_) {
        for (const OcclusionRoom::Run& run : room.runs) {
            const glm::dvec3 first = (glm::dvec3(placeOf(key) * kChunkExtent + run.at) + 0.5) * voxels;
            const glm::dvec3 place(info_.patientFromVoxel * glm::dvec4(first, 1)),
                step = voxels * glm::dvec3(info_.patientFromVoxel[0]);
            for (int n = 0; n < native::kOcclusionRun; ++n)
                to[run.to + static_cast<std::size_t>(n)] =
                    lightTexel(shadow.light(place + double(n) * step, key.level));
        }
        to += kChunkTexels;
    }
}

void VoxelLight::lightChunks(std::span<const ChunkKey> keys, BrickCache& cache) {
    // A map's places stay where they are.
    std::vector<LitChunk*> chunks;
    for (const ChunkKey& key : keys)
        chunks.push_back(&chunks_.at(key));
    std::mutex mutex;
    std::vector<std::unique_ptr<OcclusionRoom>> rooms;
    parallelFor(keys.size(), threads_, [&](std::size_t n) {
        std::unique_ptr<OcclusionRoom> room;
        {
            const std::lock_guard lock(mutex);
            if (!rooms.empty()) {
                room = std::move(rooms.back());
                rooms.pop_back();
            }
        }
        if (!room)
            room = std::make_unique<OcclusionRoom>(occluder_.mostReach(), occluder_.gathersEmission());
        light(keys[n], *chunks[n], cache, *room);
        const std::lock_guard lock(mutex);
        rooms.push_back(std::move(room));
    });
}

/// Those that were not used for longest; chunks without texels take no room.
void VoxelLight::forget(std::size_t most) {
    std::vector<std::pair<std::uint64_t, ChunkKey>> kept;
    for (const auto& [key, chunk] : chunks_)
        if (!chunk.texels.empty())
            kept.emplace_back(chunk.used, key);
    if (kept.size() <= most)
        return;
    std::sort(kept.begin(), kept.end());
    for (std::size_t n = 0; n < kept.size() - most; ++n)
        chunks_.erase(kept[n].second);
}

/// Bricks [first, end): of several at once only as many as little memory holds.
void VoxelLight::fillAndPut(const std::vector<Ordered>& ordered, std::size_t first, std::size_t end,
                            const Put& put) const {
    struct Filled {
        int channel;
        Chunk samples;
    };
    std::vector<Filled> filled((end - first) * static_cast<std::size_t>(channels_));
    parallelFor(filled.size(), threads_, [&](std::size_t n) {
        const BrickToLight& b = ordered[first + n / static_cast<std::size_t>(channels_)].second;
        Filled& f = filled[n];
        f.channel = static_cast<int>(n % static_cast<std::size_t>(channels_));
        // Laid out as a chunk's samples, so that planes take it as one.
        f.samples.size = kChunkTexels * sizeof(std::uint16_t);
        f.samples.bytes = std::make_unique<std::byte[]>(f.samples.size);
        fill(b, f.channel, reinterpret_cast<std::uint16_t*>(f.samples.bytes.get()));
    });
    for (std::size_t n = 0; n < filled.size(); ++n) {
        const BrickToLight& b = ordered[first + n / static_cast<std::size_t>(channels_)].second;
        put(b, filled[n].channel, filled[n].samples, kBrickExtent >> b.level);
    }
}

void VoxelLight::light(std::vector<BrickToLight> bricks, BrickCache& cache, const Put& put) {
    const glm::ivec3 grid = brickGrid(info_.extentVoxels);
    const auto levelOf = [&](const BrickToLight& b) { return std::max(b.level, finest_); };
    const auto chunkOfBrick = [&](const BrickToLight& b) {
        const int level = levelOf(b);
        const glm::ivec3 at = gridPosition(b.brick, grid) >> level;
        return ChunkKey{level, at.x, at.y, at.z};
    };
    std::vector<Ordered> ordered;
    for (const BrickToLight& b : bricks)
        ordered.push_back({{levelOf(b), mortonOf(chunkOfBrick(b))}, b});
    std::sort(ordered.begin(), ordered.end(), [](const auto& a, const auto& b) {
        return a.first != b.first ? a.first < b.first : a.second.brick < b.second.brick;
    });

    for (std::size_t first = 0; first < ordered.size();) {
        // Bricks of so many chunks, and the chunks that they read.
        ++turn_;
        std::size_t end = first, chunks = 0;
        std::set<ChunkKey> wanted;
        for (; end < ordered.size(); ++end) {
            const BrickToLight& b = ordered[end].second;
            if (end == first || ordered[end].first != ordered[end - 1].first)
                if (++chunks > kChunksAtATime)
                    break;
            const int level = levelOf(b), edge = kBrickExtent >> level;
            const int margin = level > b.level ? 1 : 0;
            const glm::ivec3 low = gridPosition(b.brick, grid) * edge;
            const glm::ivec3 last = levelExtent(info_.extentVoxels, level) - 1;
            const glm::ivec3 from = glm::max(low - margin, glm::ivec3(0)),
                             to = glm::min(low + edge - 1 + margin, last);
            for (int z = from.z >> 5; z <= to.z >> 5; ++z)
                for (int y = from.y >> 5; y <= to.y >> 5; ++y)
                    for (int x = from.x >> 5; x <= to.x >> 5; ++x) {
                        const ChunkKey key{level, x, y, z};
                        LitChunk& chunk = chunks_[key];
                        chunk.used = turn_;
                        if (chunk.isWhole)
                            continue;
                        const auto along = glm::ivec3(1 << level);
                        if (chunk.bricks.empty())
                            chunk.bricks.assign(cellCount(along), 0);
                        const glm::ivec3 corner = placeOf(key) << level; // its first brick
                        const glm::ivec3 lowest = glm::max(from / edge - corner, glm::ivec3(0)),
                                         highest = glm::min(to / edge - corner, along - 1);
                        for (int k = lowest.z; k <= highest.z; ++k)
                            for (int j = lowest.y; j <= highest.y; ++j)
                                for (int i = lowest.x; i <= highest.x; ++i)
                                    if (std::uint8_t& mine = chunk.bricks[linearIndex({i, j, k}, along)];
                                        mine == 0) {
                                        mine = 1;
                                        wanted.insert(key);
                                    }
                    }
        }
        lightChunks(std::vector<ChunkKey>(wanted.begin(), wanted.end()), cache);

        for (std::size_t from = first; from < end; from += kBricksAtATime)
            fillAndPut(ordered, from, std::min(end, from + kBricksAtATime), put);
        forget(kLeastChunks);
        first = end;
    }
}

namespace {

/// Between samples of a cube, at places that are twice, four times ... as dense.
/// @param width  of the cube, one more than needed around; @param scale  samples from one place to the next
void fillBetween(const std::vector<float>& cube, int width, float scale, int edge, std::uint16_t* out) {
    std::vector<float> slice(static_cast<std::size_t>(width * width)), row(static_cast<std::size_t>(width));
    const auto place = [&](int i) { return (static_cast<float>(i) + 0.5f) * scale + 0.5f; };
    const auto between = [](const float* a, const float* b, float part, std::size_t count, float* to) {
        for (std::size_t n = 0; n < count; ++n)
            to[n] = a[n] + part * (b[n] - a[n]);
    };
    for (int z = 0; z < edge; ++z) {
        const auto k = static_cast<int>(place(z));
        const float* const low = cube.data() + k * width * width;
        between(low, low + width * width, place(z) - static_cast<float>(k), slice.size(), slice.data());
        for (int y = 0; y < edge; ++y) {
            const auto j = static_cast<int>(place(y));
            between(slice.data() + j * width, slice.data() + (j + 1) * width,
                    place(y) - static_cast<float>(j), row.size(), row.data());
            std::uint16_t* const to = out + linearIndex({0, y, z}, glm::ivec3(kChunkExtent));
            for (int x = 0; x < edge; ++x) {
                const auto i = static_cast<int>(place(x));
                const float part = place(x) - static_cast<float>(i);
                const float value =
                    row[static_cast<std::size_t>(i)] +
                    part * (row[static_cast<std::size_t>(i) + 1] - row[static_cast<std::size_t>(i)]);
                to[x] = static_cast<std::uint16_t>(value + 0.5f);
            }
        }
    }
}

} // namespace

/// @param out  32^3 texels of which a brick's are the first along each axis
void VoxelLight::fill(const BrickToLight& b, int channel, std::uint16_t* out) const {
    const glm::ivec3 at = gridPosition(b.brick, brickGrid(info_.extentVoxels));
    const int level = std::max(b.level, finest_), edge = kBrickExtent >> b.level;
    const glm::ivec3 last = levelExtent(info_.extentVoxels, level) - 1, chunkEdge(kChunkExtent);
    const std::size_t texels = static_cast<std::size_t>(channel) * kChunkTexels;
    if (level == b.level) { // all in one chunk
        const ChunkKey key = chunkHolding(at * edge, level);
        const LitChunk& chunk = chunks_.at(key);
        const glm::ivec3 first = at * edge - placeOf(key) * kChunkExtent;
        for (int z = 0; z < edge; ++z)
            for (int y = 0; y < edge; ++y) {
                std::uint16_t* const to = out + linearIndex({0, y, z}, chunkEdge);
                if (chunk.texels.empty())
                    std::fill_n(to, edge, lightTexel(1));
                else
                    std::copy_n(chunk.texels.data() + texels +
                                    linearIndex(first + glm::ivec3(0, y, z), chunkEdge),
                                edge, to);
            }
        return;
    }
    // Coarser samples in and around the brick, then between them.
    const int coarse = kBrickExtent >> level, width = coarse + 2;
    std::vector<float> samples(static_cast<std::size_t>(width * width * width));
    bool any = false;
    for (int z = 0; z < width; ++z)
        for (int y = 0; y < width; ++y)
            for (int x = 0; x < width; ++x) {
                const glm::ivec3 sample =
                    glm::clamp(at * coarse + glm::ivec3(x, y, z) - 1, glm::ivec3(0), last);
                const LitChunk& chunk = chunks_.at(chunkHolding(sample, level));
                any = any || !chunk.texels.empty();
                samples[linearIndex({x, y, z}, glm::ivec3(width))] =
                    chunk.texels.empty()
                        ? lightTexel(1)
                        : chunk.texels[texels + linearIndex(sample & (kChunkExtent - 1), chunkEdge)];
            }
    if (any)
        fillBetween(samples, width, std::ldexp(1.0f, b.level - level), edge, out);
    else
        std::fill_n(out, kChunkTexels, lightTexel(1));
}

std::uint16_t VoxelLight::standing(std::size_t brick, int channel, BrickCache& cache) {
    const glm::ivec3 at = gridPosition(brick, brickGrid(info_.extentVoxels));
    const ChunkKey key = chunkHolding(at, kLevelCount - 1);
    LitChunk& chunk = chunks_[key];
    if (!chunk.isWhole) {
        chunk.isWhole = true;
        lightChunks({&key, 1}, cache);
    }
    chunk.used = turn_;
    return chunk.texels.empty()
               ? lightTexel(1)
               : chunk.texels[static_cast<std::size_t>(channel) * kChunkTexels +
                              linearIndex(at & (kChunkExtent - 1), glm::ivec3(kChunkExtent))];
}

} // namespace tessera
