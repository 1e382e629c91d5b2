// render/light/voxel_light.cpp: see voxel_light.h.
#include "render/light/voxel_light.h"

#include "core/base/brick.h"
#include "core/base/error.h"
#include "core/base/threads.h"
#include "render/light/histogram_light.h"
#include "render/light/map_light.h"
#include "render/light/scatter_light.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <optional>
#include <set>

namespace tessera {
namespace {

constexpr std::size_t kChunksAtATime = 16, kBricksAtATime = 32;
constexpr std::size_t kLeastChunks = 128; // kept for neighbours

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
/// Occlusion that rays find, if it is such.
std::optional<Occlusion> alongRays(const std::optional<Occlusion>& occlusion) {
    return occlusion && occlusion->method != OcclusionMethod::histogram ? occlusion : std::nullopt;
}
ChunkKey chunkHolding(const glm::ivec3& sample, int level) {
    const glm::ivec3 at = sample >> 5;
    return {level, at.x, at.y, at.z};
}

} // namespace

VoxelLight::VoxelLight(const VolumeInfo& info, const Statistics& statistics, const Lighting& lighting,
                       int threads, const LocalHistograms* histograms)
    : info_(info), threads_(threads > 0 ? threads : defaultThreads()),
      occluder_(info, statistics, alongRays(lighting.occlusion)),
      shadows_(info, occluder_.target(), lightChannels(lighting) - ambientChannels(lighting)) {
    if (lighting.occlusion && lighting.occlusion->method == OcclusionMethod::histogram) {
        TESSERA_CHECK(histograms);
        ambient_ = std::make_unique<HistogramLight>(info, *histograms, *lighting.occlusion);
    } else if (lighting.occlusion) {
        ambient_ = std::make_unique<OcclusionLight>(occluder_, *lighting.occlusion);
    }
    if (scatters(lighting)) {
        if (scattersByMaps(lighting))
            ambient_ = std::make_unique<MapLight>(info, lighting, std::move(ambient_));
        else
            ambient_ = std::make_unique<ScatterLight>(info, statistics, lighting, std::move(ambient_));
        ambientByMaps_ = shadows_.channels() > 0;
    }
    sources_ = {ambient_.get(), shadows_.channels() > 0 ? &shadows_ : nullptr};
    // Where rays ask for a coarser level, all light is of that.
    finest_.fill(std::max(occluder_.finestLevel(), std::clamp(lighting.finestLevel, 0, kLevelCount - 1)));
    for (std::size_t part = 0; part < kLightParts; ++part)
        if (sources_[part])
            finest_[part] = std::max(finest_[part], sources_[part]->finestLevel());
    if (!sources_[1])
        finest_[1] = finest_[0];
    TESSERA_CHECK(channelsOf(0) == ambientChannels(lighting));
    TESSERA_CHECK(channelsOf(0) + channelsOf(1) <= leaf::kMostLightChannels);
}

LightParts VoxelLight::quickParts() const {
    LightParts parts = 0;
    for (std::size_t part = 0; part < kLightParts; ++part)
        if (sources_[part] && sources_[part]->isQuick())
            parts |= 1u << part;
    return parts;
}

std::size_t VoxelLight::bytes(const VolumeInfo& info, const Lighting& lighting, int threads, bool amongOthers,
                              bool meshes) {
    const int used = threads > 0 ? threads : defaultThreads();
    glm::ivec3 reach(0);
    const std::optional<Occlusion> rays = alongRays(lighting.occlusion);
    if (rays)
        for (int level = occlusionLevel(*rays, info); level < kLevelCount; ++level)
            reach = glm::max(reach, occlusionRays(*rays, info, level).reach);
    return static_cast<std::size_t>(used) *
               OcclusionRoom::bytes(reach, rays && rays->emission > 0,
                                    rays && rays->directions == OcclusionDirections::hemisphere,
                                    rays && meshes) +
           (rays ? (amongOthers ? 2 : 1) * ChunkExtinctions::bytes(info, used) : 0) +
           (scatters(lighting) && !scattersByMaps(lighting) ? ScatterLight::bytes(info, lighting, used) : 0) +
           2 * kLeastChunks * kChunkTexels * sizeof(std::uint16_t) *
               static_cast<std::size_t>(lightChannels(lighting));
}

void VoxelLight::functionChanged(const TransferTable& table, const Optics& optics) {
    occluder_.setFunction(table, optics);
    for (LightSource* source : sources_)
        if (source)
            source->functionChanged(table, optics);
    chunks_.clear();
}

void VoxelLight::setShadows(std::span<const ShadowMaps> shadows) {
    shadows_.setShadows(shadows);
    forgetPart(1);
    if (ambientByMaps_) {
        ambient_->setShadows(shadows);
        forgetPart(0);
    }
}

void VoxelLight::setOtherShadows(std::vector<std::span<const ShadowMaps>> others) {
    shadows_.setOtherShadows(std::move(others));
    forgetPart(1);
}

void VoxelLight::setOtherTissue(std::vector<Occluder::Other> others) {
    occluder_.setOthers(std::move(others));
    forgetPart(0);
}

void VoxelLight::setMeshes(const MeshBits* bits, int level) {
    occluder_.setMeshes(bits, level);
    forgetPart(0);
}

void VoxelLight::forgetPart(std::size_t part) {
    for (auto& [key, chunk] : chunks_)
        chunk.parts[part] = {};
}

/// Its bricks to light; the light of others is unchanged, or computed again with the same result.
void VoxelLight::light(const ChunkKey& key, LitChunk& chunk, BrickCache& cache, OcclusionRoom& room) const {
    std::vector<std::uint8_t> bricks(cellCount(glm::ivec3(1 << key.level)), 0);
    bool wanted[kLightParts] = {};
    for (std::size_t part = 0; part < kLightParts; ++part) {
        std::vector<State>& states = chunk.parts[part].bricks;
        chunk.parts[part].isWanted = false;
        for (std::size_t b = 0; b < states.size(); ++b)
            if (states[b] == State::wanted) {
                bricks[b] = 1;
                wanted[part] = true;
                states[b] = State::lit;
            }
    }
    occluder_.find(key, bricks, wanted[0] && sources_[0]->readsTissue(), cache, room);
    if (room.runs.empty())
        return; // invisible: its texels are never read
    for (std::size_t part = 0; part < kLightParts; ++part)
        if (wanted[part]) {
            std::vector<std::uint16_t>& texels = chunk.parts[part].texels;
            if (texels.empty())
                texels.assign(kChunkTexels * static_cast<std::size_t>(channelsOf(part)), lightTexel(1));
            sources_[part]->fill(key, cache, room, texels.data());
        }
}

void VoxelLight::lightChunks(std::span<const ChunkKey> keys, BrickCache& cache) {
    // Iterators of a map stay valid.
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
            room = std::make_unique<OcclusionRoom>(occluder_.mostReach(), occluder_.gathersEmission(),
                                                   occluder_.seesSurfaces(), occluder_.meetsMeshes());
        light(keys[n], *chunks[n], cache, *room);
        const std::lock_guard lock(mutex);
        rooms.push_back(std::move(room));
    });
}

/// Least recently used ones; chunks without texels take no memory.
void VoxelLight::forget(std::size_t most) {
    std::vector<std::pair<std::uint64_t, ChunkKey>> kept;
    for (const auto& [key, chunk] : chunks_)
        if (!chunk.parts[0].texels.empty() || !chunk.parts[1].texels.empty())
            kept.emplace_back(chunk.used, key);
    if (kept.size() <= most)
        return;
    std::sort(kept.begin(), kept.end());
    for (std::size_t n = 0; n < kept.size() - most; ++n)
        chunks_.erase(kept[n].second);
}

/// Bricks [first, end): at once only as many as fit into a small memory.
void VoxelLight::fillAndPut(const std::vector<Ordered>& ordered, std::size_t first, std::size_t end,
                            LightParts parts, const Put& put, bool manyAtOnce) const {
    struct Filled {
        std::size_t brick; // of ordered
        std::size_t part;
        int n; // channel of the part
        Chunk samples;
    };
    std::vector<Filled> filled;
    for (std::size_t b = first; b < end; ++b)
        for (std::size_t part = 0; part < kLightParts; ++part)
            for (int n = 0; (parts >> part & 1u) != 0 && n < channelsOf(part); ++n)
                filled.push_back({b, part, n, {}});
    const auto give = [&](Filled& f) {
        const BrickToLight& b = ordered[f.brick].second;
        put(b, firstChannelOf(f.part) + f.n, f.samples, kBrickExtent >> b.level);
        f.samples = {};
    };
    parallelFor(filled.size(), threads_, [&](std::size_t n) {
        Filled& f = filled[n];
        // In the layout of a chunk's samples, as planes need it.
        f.samples.size = kChunkTexels * sizeof(std::uint16_t);
        f.samples.bytes = std::make_unique_for_overwrite<std::byte[]>(f.samples.size);
        fill(ordered[f.brick].second, f.part, f.n, reinterpret_cast<std::uint16_t*>(f.samples.bytes.get()));
        if (manyAtOnce)
            give(f);
    });
    for (std::size_t n = 0; !manyAtOnce && n < filled.size(); ++n)
        give(filled[n]);
}

std::pair<int, std::uint64_t> VoxelLight::placeInOrder(const BrickToLight& b, const glm::ivec3& grid) {
    const glm::ivec3 at = gridPosition(b.brick, grid) >> b.lightLevel;
    return {b.lightLevel, mortonOf({b.lightLevel, at.x, at.y, at.z})};
}

/// Bricks [first, end) of a chunk, and expected ones.
void VoxelLight::want(const ChunkKey& key, LitPart& lit, const glm::ivec3& lowest, const glm::ivec3& highest,
                      std::span<const std::uint8_t> expected) const {
    const auto along = glm::ivec3(1 << key.level);
    const glm::ivec3 corner = placeOf(key) << key.level, grid = brickGrid(info_.extentVoxels);
    if (lit.bricks.empty())
        lit.bricks.assign(cellCount(along), State::dark);
    const auto mark = [&](const glm::ivec3& at) {
        State& mine = lit.bricks[linearIndex(at, along)];
        const bool isNew = mine == State::dark;
        if (isNew)
            mine = State::wanted;
        lit.isWanted = lit.isWanted || isNew;
    };
    for (int z = lowest.z; z <= highest.z; ++z)
        for (int y = lowest.y; y <= highest.y; ++y)
            for (int x = lowest.x; x <= highest.x; ++x)
                mark({x, y, z});
    if (!lit.isWanted)
        return;
    const glm::ivec3 end = glm::min(along, grid - corner);
    for (int z = 0; z < end.z; ++z)
        for (int y = 0; y < end.y; ++y)
            for (int x = 0; x < end.x; ++x)
                if (expected[linearIndex(corner + glm::ivec3(x, y, z), grid)] == key.level)
                    mark({x, y, z});
}

void VoxelLight::light(std::vector<BrickToLight> bricks, std::span<const std::uint8_t> expected,
                       LightParts parts, BrickCache& cache, const Put& put, bool manyAtOnce) {
    for (std::size_t part = 0; part < kLightParts; ++part)
        if (!sources_[part])
            parts &= ~(1u << part);
    TESSERA_CHECK((parts & kShadowLight) == 0 || shadows_.hasMaps());
    for (const BrickToLight& b : bricks)
        TESSERA_CHECK(b.lightLevel >= std::max(b.level, finestLevel()));
    if (finest_[0] == finest_[1]) {
        lightAlike(std::move(bricks), expected, parts, cache, put, manyAtOnce);
        return;
    }
    for (std::size_t part = 0; part < kLightParts; ++part)
        if ((parts >> part & 1u) != 0) { // each at the levels that it has
            std::vector<BrickToLight> own = bricks;
            for (BrickToLight& b : own)
                b.lightLevel = std::max(b.lightLevel, finest_[part]);
            std::vector<std::uint8_t> levels(expected.begin(), expected.end());
            for (std::uint8_t& level : levels)
                level = std::max(level, static_cast<std::uint8_t>(finest_[part]));
            lightAlike(std::move(own), levels, 1u << part, cache, put, manyAtOnce);
        }
}

/// Parts of light whose levels are those of the bricks.
void VoxelLight::lightAlike(std::vector<BrickToLight> bricks, std::span<const std::uint8_t> expected,
                            LightParts parts, BrickCache& cache, const Put& put, bool manyAtOnce) {
    const glm::ivec3 grid = brickGrid(info_.extentVoxels);
    std::vector<Ordered> ordered;
    for (const BrickToLight& b : bricks)
        ordered.push_back({placeInOrder(b, grid), b});
    std::sort(ordered.begin(), ordered.end(), [](const auto& a, const auto& b) {
        return a.first != b.first ? a.first < b.first : a.second.brick < b.second.brick;
    });

    for (std::size_t first = 0; first < ordered.size();) {
        // Bricks of this number of chunks, and the chunks that they read.
        ++turn_;
        std::size_t end = first, chunks = 0;
        std::set<ChunkKey> wanted;
        for (; end < ordered.size(); ++end) {
            const BrickToLight& b = ordered[end].second;
            if (end == first || ordered[end].first != ordered[end - 1].first)
                if (++chunks > kChunksAtATime)
                    break;
            const int level = b.lightLevel, edge = kBrickExtent >> level;
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
                        const auto along = glm::ivec3(1 << level);
                        const glm::ivec3 corner = placeOf(key) << level; // its first brick
                        const glm::ivec3 lowest = glm::max(from / edge - corner, glm::ivec3(0)),
                                         highest = glm::min(to / edge - corner, along - 1);
                        for (std::size_t part = 0; part < kLightParts; ++part)
                            if ((parts >> part & 1u) != 0) {
                                want(key, chunk.parts[part], lowest, highest, expected);
                                if (chunk.parts[part].isWanted)
                                    wanted.insert(key);
                            }
                    }
        }
        lightChunks(std::vector<ChunkKey>(wanted.begin(), wanted.end()), cache);

        for (std::size_t from = first; from < end; from += kBricksAtATime)
            fillAndPut(ordered, from, std::min(end, from + kBricksAtATime), parts, put, manyAtOnce);
        forget(kLeastChunks);
        first = end;
    }
}

namespace {

/// Interpolates samples of a cube at points that are twice, four times ... as dense.
/// @param width  of the cube, one more than needed around
/// @param scale  samples from one place to the next
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
void VoxelLight::fill(const BrickToLight& b, std::size_t part, int n, std::uint16_t* out) const {
    const glm::ivec3 at = gridPosition(b.brick, brickGrid(info_.extentVoxels));
    const int level = b.lightLevel, edge = kBrickExtent >> b.level;
    const glm::ivec3 last = levelExtent(info_.extentVoxels, level) - 1, chunkEdge(kChunkExtent);
    const std::size_t texels = static_cast<std::size_t>(n) * kChunkTexels;
    if (level == b.level) { // all in one chunk
        const ChunkKey key = chunkHolding(at * edge, level);
        const LitPart& lit = chunks_.at(key).parts[part];
        const glm::ivec3 first = at * edge - placeOf(key) * kChunkExtent;
        for (int z = 0; z < edge; ++z)
            for (int y = 0; y < edge; ++y) {
                std::uint16_t* const to = out + linearIndex({0, y, z}, chunkEdge);
                if (lit.texels.empty())
                    std::fill_n(to, edge, lightTexel(1));
                else
                    std::copy_n(lit.texels.data() + texels +
                                    linearIndex(first + glm::ivec3(0, y, z), chunkEdge),
                                edge, to);
            }
        return;
    }
    // Coarser samples in and around the brick, then interpolation.
    const int coarse = kBrickExtent >> level, width = coarse + 2;
    std::vector<float> samples(static_cast<std::size_t>(width * width * width));
    bool any = false;
    const LitPart* lit = nullptr; // of the chunk that holds the sample before
    ChunkKey held{-1, 0, 0, 0};
    for (int z = 0; z < width; ++z)
        for (int y = 0; y < width; ++y)
            for (int x = 0; x < width; ++x) {
                const glm::ivec3 sample =
                    glm::clamp(at * coarse + glm::ivec3(x, y, z) - 1, glm::ivec3(0), last);
                if (const ChunkKey key = chunkHolding(sample, level); !lit || key != held) {
                    lit = &chunks_.at(key).parts[part];
                    held = key;
                    any = any || !lit->texels.empty();
                }
                samples[linearIndex({x, y, z}, glm::ivec3(width))] =
                    lit->texels.empty()
                        ? lightTexel(1)
                        : lit->texels[texels + linearIndex(sample & (kChunkExtent - 1), chunkEdge)];
            }
    if (any)
        fillBetween(samples, width, std::ldexp(1.0f, b.level - level), edge, out);
    else
        for (int z = 0; z < edge; ++z)
            for (int y = 0; y < edge; ++y)
                std::fill_n(out + linearIndex({0, y, z}, chunkEdge), edge, lightTexel(1));
}

std::uint16_t VoxelLight::standing(std::size_t brick, std::size_t part, int n, BrickCache& cache) {
    const glm::ivec3 at = gridPosition(brick, brickGrid(info_.extentVoxels));
    const ChunkKey key = chunkHolding(at, kLevelCount - 1);
    LitChunk& chunk = chunks_[key];
    LitPart& lit = chunk.parts[part];
    if (!lit.isWhole) {
        lit.isWhole = true;
        lit.bricks.assign(std::size_t{1} << (3 * (kLevelCount - 1)), State::wanted);
        lightChunks({&key, 1}, cache);
    }
    chunk.used = turn_;
    return lit.texels.empty() ? lightTexel(1)
                              : lit.texels[static_cast<std::size_t>(n) * kChunkTexels +
                                           linearIndex(at & (kChunkExtent - 1), glm::ivec3(kChunkExtent))];
}

} // namespace tessera
