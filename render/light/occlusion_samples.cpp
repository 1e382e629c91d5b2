// render/light/occlusion_samples.cpp: what rays of occlusion read around a chunk, and the runs of samples
// that something shows near: see occlusion.h.
#include "core/base/brick.h"
#include "core/base/error.h"
#include "render/light/occlusion.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace tessera {
namespace {

std::size_t runIndex(int run, int y, int z) {
    constexpr int kEdge = kChunkExtent + 2 * OcclusionRoom::kAround;
    return static_cast<std::size_t>((z * kEdge + y) * OcclusionRoom::kRunsPerRow + run);
}

} // namespace

/// The range of a chunk and a voxel around it. Means are within the range of their values.
Occluder::Range Occluder::rangeOf(const ChunkKey& chunk) const {
    const glm::ivec3 low = glm::ivec3(chunk.i, chunk.j, chunk.k) << chunk.level;
    const glm::ivec3 high = glm::min(low + (1 << chunk.level), statistics_.bricks);
    Range range;
    for (int z = low.z; z < high.z; ++z)
        for (int y = low.y; y < high.y; ++y)
            for (int x = low.x; x < high.x; ++x) {
                const std::size_t b = linearIndex({x, y, z}, statistics_.bricks);
                range.add(statistics_.brickMin[b], statistics_.brickMax[b], statistics_.showsOfBrick(b, 1));
            }
    return range;
}

bool Occluder::isEmpty(const Range& range) const {
    if ((range.shows & kShowsMedium) != 0)
        return false;
    if (range.shows == 0)
        return true;
    const double a = info_.rescaleSlope * range.low + info_.rescaleIntercept;
    const double b = info_.rescaleSlope * range.high + info_.rescaleIntercept;
    return table_->emptyOver(std::min(a, b), std::max(a, b));
}

/// Space behind an isosurface takes light, though it may be invisible.
bool Occluder::letsAllThrough(const Range& range) const {
    return isEmpty(range) && (optics_->surfaces.empty() || range.high < optics_->surfaces.front().isovalue);
}

std::size_t ChunkExtinctions::bytes(const VolumeInfo& info, int threads) {
    std::size_t chunks = 0;
    for (int level = 0; level < kLevelCount; ++level)
        chunks += cellCount(chunkGrid(info.extentVoxels, level));
    return std::min(chunks, kMost + static_cast<std::size_t>(threads)) *
           (cellCount(glm::ivec3(kChunkExtent)) * sizeof(float) + kChunkExtent * kChunkExtent);
}

std::shared_ptr<const ChunkExtinctions::Samples>
ChunkExtinctions::get(const ChunkKey& key, const std::function<void(Samples&)>& make) {
    std::shared_ptr<Kept> kept;
    {
        const std::lock_guard lock(mutex_);
        if (const auto found = kept_.find(key); found != kept_.end()) {
            kept = found->second;
        } else {
            if (kept_.size() >= kMost)
                kept_.erase(std::min_element(kept_.begin(), kept_.end(), [](const auto& a, const auto& b) {
                    return a.second->used < b.second->used;
                }));
            kept = kept_.emplace(key, std::make_shared<Kept>()).first->second;
        }
        kept->used = ++turn_;
    }
    std::call_once(kept->isMade, make, std::ref(kept->samples));
    return {kept, &kept->samples};
}

void ChunkExtinctions::clear() {
    const std::lock_guard lock(mutex_);
    kept_.clear();
}

namespace {

template <typename Stored> std::size_t entryOf(Stored stored) {
    return static_cast<std::size_t>(int(stored) - int(std::numeric_limits<Stored>::min()));
}

/// Finds runs near samples [low,high): the first of them, their number along x, and the range.
template <typename Visit>
void forEachRun(const glm::ivec3& first, const glm::ivec3& low, const glm::ivec3& high, OcclusionRoom& room,
                const Visit& visit) {
    constexpr int kEdge = kChunkExtent + 2 * OcclusionRoom::kAround;
    const glm::ivec3 near = first + room.reach - OcclusionRoom::kAround; // from here on ranges are needed
    const glm::ivec3 from = glm::max(low, near), to = glm::min(high, near + kEdge);
    for (int z = from.z; z < to.z; ++z)
        for (int y = from.y; y < to.y; ++y)
            for (int run = 0; run < OcclusionRoom::kRunsPerRow; ++run) {
                const int start = std::max(from.x, near.x + run * OcclusionRoom::kRun);
                const int end =
                    std::min(to.x, near.x + (run + 1) * OcclusionRoom::kRun + 2 * OcclusionRoom::kAround);
                const std::size_t index = runIndex(run, y - near.y, z - near.z);
                if (start < end)
                    visit(glm::ivec3(start, y, z), end - start, room.low[index], room.high[index]);
            }
}

} // namespace

/// Extinction of a sample with gradient opacity, by differences of adjacent samples; one-sided at a chunk's
/// face, so that no other chunk is read.
/// @param samples  of the chunk
/// @param at, last  in it; the last one that it has
template <typename Stored>
float Occluder::gradedExtinction(const Stored* samples, const glm::ivec3& at, const glm::ivec3& last,
                                 int level) const {
    const auto value = [&](const glm::ivec3& i) {
        return static_cast<float>(samples[linearIndex(i, glm::ivec3(kChunkExtent))]);
    };
    glm::vec3 gradient(0);
    for (int axis = 0; axis < 3; ++axis) {
        glm::ivec3 before = at, after = at;
        before[axis] = std::max(at[axis] - 1, 0);
        after[axis] = std::min(at[axis] + 1, last[axis]);
        if (after[axis] > before[axis])
            gradient[axis] =
                (value(after) - value(before)) / static_cast<float>((after[axis] - before[axis]) << level);
    }
    return occlusionExtinction(*optics_, value(at), gradientFactor(*optics_, gradient));
}

template <typename Stored>
void Occluder::fillExtinctions(const ChunkKey& key, const Chunk& chunk,
                               ChunkExtinctions::Samples& out) const {
    const auto* const all = reinterpret_cast<const Stored*>(chunk.bytes.get());
    const glm::ivec3 size =
        glm::min(levelExtent(info_.extentVoxels, key.level) - kChunkExtent * glm::ivec3(key.i, key.j, key.k),
                 glm::ivec3(kChunkExtent));
    auto extinction = std::make_unique<float[]>(cellCount(glm::ivec3(kChunkExtent)));
    out.rowShows.assign(static_cast<std::size_t>(kChunkExtent * kChunkExtent), 0);
    bool any = false;
    for (int z = 0; z < size.z; ++z)
        for (int y = 0; y < size.y; ++y) {
            const glm::ivec3 start(0, y, z);
            const Stored* const from = all + linearIndex(start, glm::ivec3(kChunkExtent));
            float* const to = extinction.get() + linearIndex(start, glm::ivec3(kChunkExtent));
            float most = 0;
            for (int x = 0; x < size.x; ++x) {
                if constexpr (std::is_integral_v<Stored>)
                    to[x] = extinctionOf_[entryOf(from[x])];
                else
                    to[x] = occlusionExtinction(*optics_, from[x]);
                if (to[x] > 0 && optics_->grades())
                    to[x] = gradedExtinction(all, start + glm::ivec3(x, 0, 0), size - 1, key.level);
                most = std::max(most, to[x]);
            }
            out.rowShows[static_cast<std::size_t>(z * kChunkExtent + y)] = most > 0 ? 1 : 0;
            any = any || most > 0;
        }
    if (any)
        out.extinction = std::move(extinction);
}

/// The labels' shares of a chunk's extinctions, and their medium.
void Occluder::takeLabels(const ChunkKey& key, ChunkExtinctions::Samples& out) const {
    const std::size_t count = cellCount(glm::ivec3(kChunkExtent));
    std::vector<float> function(count), medium(count);
    labels_->extinctions(key, function, medium);
    if (!out.extinction)
        out.extinction = std::make_unique<float[]>(count);
    bool any = false;
    for (std::size_t row = 0; row < out.rowShows.size(); ++row) {
        bool shows = false;
        for (std::size_t n = row * kChunkExtent; n < (row + 1) * kChunkExtent; ++n) {
            out.extinction[n] = function[n] * out.extinction[n] + medium[n];
            shows = shows || out.extinction[n] > 0;
        }
        out.rowShows[row] = shows ? 1 : 0;
        any = any || shows;
    }
    if (!any)
        out.extinction.reset();
}

Occluder::SharedSamples Occluder::ownExtinctions(const ChunkKey& key, BrickCache& cache) const {
    return extinctions_->get(key, [&](ChunkExtinctions::Samples& out) {
        const ChunkPointer chunk = cache.get(key);
        withValueType(info_.type, [&](auto typed) { fillExtinctions<decltype(typed)>(key, *chunk, out); });
        if (labels_)
            takeLabels(key, out);
    });
}

/// Samples [low,high) of the level, all in one chunk, where there is extinction.
/// @param first  of the room
template <typename Stored>
void Occluder::readEmission(const glm::ivec3& first, const glm::ivec3& low, const glm::ivec3& high, int level,
                            const Chunk& chunk, OcclusionRoom& room) const {
    const auto* const all = reinterpret_cast<const Stored*>(chunk.bytes.get());
    const auto emissionOf = [&](Stored stored) {
        if constexpr (std::is_integral_v<Stored>)
            return emissionOf_[entryOf(stored)];
        else
            return sentBy(stored);
    };
    for (int z = low.z; z < high.z; ++z)
        for (int y = low.y; y < high.y; ++y) {
            const glm::ivec3 at = glm::ivec3(low.x, y, z) - first;
            if (room.rowShows[static_cast<std::size_t>(at.z * room.size.y + at.y)] == 0)
                continue;
            const Stored* const from =
                all + linearIndex(glm::ivec3(low.x, y, z) & (kChunkExtent - 1), glm::ivec3(kChunkExtent));
            const auto count = static_cast<std::size_t>(high.x - low.x);
            const std::size_t to = linearIndex(at, room.size);
            std::array<glm::vec3, kChunkExtent> light;
            if (scattered_)
                scattered_->at(level, {low.x, y, z}, std::span(light).first(count));
            for (std::size_t x = 0; x < count; ++x) {
                glm::vec3 sent = emissionOf(from[x]);
                if (scattered_) // what gradient opacity or labels hide scatters none
                    sent = room.extinction[to + x] > 0 ? sent * light[x] : glm::vec3(0);
                for (int c = 0; c < 3; ++c)
                    room.emission[static_cast<std::size_t>(c)][to + x] = sent[c];
            }
        }
}

/// Of the same samples, those near the room's chunk.
template <typename Stored>
void Occluder::readRanges(const glm::ivec3& first, const glm::ivec3& low, const glm::ivec3& high,
                          const Chunk& chunk, OcclusionRoom& room) const {
    const auto* const all = reinterpret_cast<const Stored*>(chunk.bytes.get());
    forEachRun(first, low, high, room, [&](const glm::ivec3& from, int count, float& least, float& most) {
        const auto* const values = all + linearIndex(from & (kChunkExtent - 1), glm::ivec3(kChunkExtent));
        const auto [lowest, highest] = std::minmax_element(values, values + count);
        least = std::min(least, static_cast<float>(*lowest));
        most = std::max(most, static_cast<float>(*highest));
    });
}

/// True if a chunk and two samples around it are invisible.
bool Occluder::nothingNear(const ChunkKey& chunk) const {
    Range range = rangeOf(chunk);
    if (chunk.level == 0) {
        const std::size_t b = linearIndex({chunk.i, chunk.j, chunk.k}, statistics_.bricks);
        range = {statistics_.wideMin[b], statistics_.wideMax[b], statistics_.showsOfBrick(b, 2)};
    } else {
        const glm::ivec3 at(chunk.i, chunk.j, chunk.k), grid = chunkGrid(info_.extentVoxels, chunk.level);
        const glm::ivec3 low = glm::max(at - 1, glm::ivec3(0)), high = glm::min(at + 1, grid - 1);
        for (int z = low.z; z <= high.z; ++z)
            for (int y = low.y; y <= high.y; ++y)
                for (int x = low.x; x <= high.x; ++x) {
                    const Range beside = rangeOf({chunk.level, x, y, z});
                    range.add(beside.low, beside.high, beside.shows);
                }
    }
    return isEmpty(range);
}

/// The range of voxels in and around a run of samples, which bounds values near it at its level and at finer
/// ones.
Occluder::Range Occluder::rangeAround(const glm::ivec3& sample, int level) const {
    const glm::ivec3 low = glm::max(sample - OcclusionRoom::kAround, glm::ivec3(0)) << level;
    const glm::ivec3 high =
        glm::min((sample + glm::ivec3(OcclusionRoom::kRun, 1, 1) + OcclusionRoom::kAround) << level,
                 info_.extentVoxels) -
        1;
    const bool byCells = level < 3; // else bricks are fine enough
    const glm::ivec3 grid = byCells ? statistics_.cells : statistics_.bricks;
    const std::vector<float>& least = byCells ? statistics_.cellMin : statistics_.brickMin;
    const std::vector<float>& most = byCells ? statistics_.cellMax : statistics_.brickMax;
    const int shift = byCells ? 3 : 5;
    Range range;
    for (int z = low.z >> shift; z <= high.z >> shift; ++z)
        for (int y = low.y >> shift; y <= high.y >> shift; ++y)
            for (int x = low.x >> shift; x <= high.x >> shift; ++x) {
                const std::size_t n = linearIndex({x, y, z}, grid);
                range.add(least[n], most[n],
                          byCells ? statistics_.showsOfCell(n) : statistics_.showsOfBrick(n, 1));
            }
    return range;
}

void Occluder::read(const ChunkKey& chunk, bool occludes, BrickCache& cache, OcclusionRoom& room) const {
    for (std::size_t row = 0; row < room.rowShows.size(); ++row)
        if (std::exchange(room.rowShows[row], std::uint8_t{0}) != 0) {
            const auto at = static_cast<std::ptrdiff_t>(row) * room.size.x;
            std::fill_n(room.extinction.begin() + at, room.size.x, 0.0f);
            if (!room.ofMeshes.empty())
                std::fill_n(room.ofMeshes.begin() + at, room.size.x, 0.0f);
            for (std::vector<float>& sent : room.emission)
                if (!sent.empty())
                    std::fill_n(sent.begin() + at, room.size.x, 0.0f);
        }
    std::fill(room.low.begin(), room.low.end(), std::numeric_limits<float>::max());
    std::fill(room.high.begin(), room.high.end(), std::numeric_limits<float>::lowest());
    const glm::ivec3 extent = levelExtent(info_.extentVoxels, chunk.level);
    const glm::ivec3 own = glm::ivec3(chunk.i, chunk.j, chunk.k) * kChunkExtent, first = own - room.reach;
    const glm::ivec3 low = glm::max(first, glm::ivec3(0));
    const glm::ivec3 high = glm::min(own + kChunkExtent + room.reach, extent);
    const glm::ivec3 lastChunk = (high - 1) >> 5;
    for (int z = low.z >> 5; z <= lastChunk.z; ++z)
        for (int y = low.y >> 5; y <= lastChunk.y; ++y)
            for (int x = low.x >> 5; x <= lastChunk.x; ++x) {
                const ChunkKey key{chunk.level, x, y, z};
                const glm::ivec3 corner = glm::ivec3(x, y, z) * kChunkExtent;
                const glm::ivec3 from = glm::max(low, corner), to = glm::min(high, corner + kChunkExtent);
                // As does everything within a voxel of it.
                if (letsAllThrough(rangeOf(key)) && (!occludes || othersLetThrough(key)))
                    continue;
                const auto shown = occludes ? extinctionsOf(key, cache) : nullptr;
                const bool shows = shown && shown->extinction;
                for (int k = from.z; shows && k < to.z; ++k)
                    for (int j = from.y; j < to.y; ++j) {
                        const glm::ivec3 in(from.x - corner.x, j - corner.y, k - corner.z),
                            at = corner + in - first;
                        if (shown->rowShows[static_cast<std::size_t>(in.z * kChunkExtent + in.y)] == 0)
                            continue;
                        std::copy_n(shown->extinction.get() + linearIndex(in, glm::ivec3(kChunkExtent)),
                                    to.x - from.x, room.extinction.data() + linearIndex(at, room.size));
                        room.rowShows[static_cast<std::size_t>(at.z * room.size.y + at.y)] = 1;
                    }
                const bool ranges =
                    chunk.level == 0 &&
                    glm::all(glm::lessThan(from, own + kChunkExtent + OcclusionRoom::kAround)) &&
                    glm::all(glm::greaterThan(to, own - OcclusionRoom::kAround));
                const bool emits = shows && gathersEmission();
                if (!ranges && !emits)
                    continue;
                const ChunkPointer samples = cache.get(key);
                withValueType(info_.type, [&](auto typed) {
                    using Stored = decltype(typed);
                    if (emits)
                        readEmission<Stored>(first, from, to, chunk.level, *samples, room);
                    if (ranges)
                        readRanges<Stored>(first, from, to, *samples, room);
                });
            }
    if (occludes && meshes_)
        readMeshes(chunk, room);
}

void Occluder::find(const ChunkKey& chunk, std::span<const std::uint8_t> bricks, bool occludes,
                    BrickCache& cache, OcclusionRoom& room) const {
    room.runs.clear();
    if (nothingNear(chunk))
        return;
    if (occludes || chunk.level == 0) // elsewhere statistics give visibility
        read(chunk, occludes, cache, room);

    // The requested runs: by bricks, and by visibility near them.
    const glm::ivec3 own = glm::ivec3(chunk.i, chunk.j, chunk.k) * kChunkExtent;
    const glm::ivec3 samples =
        glm::min(levelExtent(info_.extentVoxels, chunk.level) - own, glm::ivec3(kChunkExtent));
    const int edge = kBrickExtent >> chunk.level, along = 1 << chunk.level;
    for (int z = 0; z < samples.z; ++z)
        for (int y = 0; y < samples.y; ++y)
            for (int run = 0; run * OcclusionRoom::kRun < samples.x; ++run) {
                bool wanted = bricks.empty();
                for (int x = run * OcclusionRoom::kRun; !wanted && x < (run + 1) * OcclusionRoom::kRun;
                     x += edge)
                    wanted = bricks[linearIndex(glm::ivec3(x, y, z) / edge, glm::ivec3(along))] != 0;
                if (!wanted)
                    continue;
                const glm::ivec3 at(run * OcclusionRoom::kRun, y, z);
                Range range;
                if (chunk.level > 0 || labels_)
                    range = rangeAround(own + at, chunk.level);
                else
                    for (int n = 0; n < (2 * OcclusionRoom::kAround + 1) * (2 * OcclusionRoom::kAround + 1);
                         ++n) {
                        const std::size_t index = runIndex(run, y + n % (2 * OcclusionRoom::kAround + 1),
                                                           z + n / (2 * OcclusionRoom::kAround + 1));
                        range.add(room.low[index], room.high[index], kShowsFunction);
                    }
                if (range.low > range.high || isEmpty(range)) // all around is empty
                    continue;
                room.runs.push_back(
                    {at, linearIndex(at + room.reach, room.size), linearIndex(at, glm::ivec3(kChunkExtent))});
            }
}

} // namespace tessera
