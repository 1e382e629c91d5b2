// render/light/occlusion.cpp: see occlusion.h.
#include "render/light/occlusion.h"

#include "core/base/brick.h"
#include "core/base/error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace tessera {
namespace {

constexpr int kRun = native::kOcclusionRun;
constexpr int kRunsPerRow = kChunkExtent / kRun;
constexpr int kAround = 2; // reach of interpolation near a sample, in samples, with or without mixed levels

int roundedUp(int n, int to) {
    return (n + to - 1) / to * to;
}
std::size_t runIndex(int run, int y, int z) {
    constexpr int kEdge = kChunkExtent + 2 * kAround;
    return static_cast<std::size_t>((z * kEdge + y) * kRunsPerRow + run);
}

} // namespace

OcclusionRoom::OcclusionRoom(const glm::ivec3& reach, bool emits, bool surfaces)
    : reach(glm::max(reach, glm::ivec3(kAround))), size(kChunkExtent + 2 * this->reach) {
    size.x = roundedUp(size.x + 1, kRun); // a step reads a sample further
    const std::size_t samples = cellCount(size + glm::ivec3(0, 1, 1));
    extinction.resize(samples);
    opacity.resize(samples);
    rowShows.resize(samples / static_cast<std::size_t>(size.x));
    rowIsSet.resize(rowShows.size());
    constexpr int kEdge = kChunkExtent + 2 * kAround;
    low.resize(static_cast<std::size_t>(kEdge * kEdge * kRunsPerRow));
    high.resize(low.size());
    light.resize(cellCount(glm::ivec3(kChunkExtent)));
    for (std::size_t c = 0; c < 3 && emits; ++c) {
        emission[c].resize(samples);
        shine[c].resize(light.size());
    }
    if (surfaces)
        for (std::vector<float>* of : {&normal[0], &normal[1], &normal[2], &rest, &weights})
            of->resize(light.size());
}

std::size_t OcclusionRoom::bytes(const glm::ivec3& reach, bool emits, bool surfaces) {
    glm::ivec3 size = kChunkExtent + 2 * glm::max(reach, glm::ivec3(kAround));
    size.x = roundedUp(size.x + 1, kRun);
    constexpr int kEdge = kChunkExtent + 2 * kAround;
    const std::size_t colours = emits ? 3 : 0;
    return sizeof(float) * ((2 + colours) * cellCount(size + glm::ivec3(0, 1, 1)) +
                            (1 + colours + (surfaces ? 5 : 0)) * cellCount(glm::ivec3(kChunkExtent)) +
                            std::size_t{2} * kEdge * kEdge * kRunsPerRow);
}

Occluder::Occluder(const VolumeInfo& info, const Statistics& statistics,
                   const std::optional<Occlusion>& occlusion, const native::PacketTarget* target)
    : info_(info), statistics_(statistics), target_(target ? *target : native::packetTarget()),
      finest_(occlusion ? occlusionLevel(*occlusion, info) : 0),
      strength_(occlusion ? occlusion->emission : 0),
      surfaces_(occlusion && occlusion->directions == OcclusionDirections::hemisphere) {
    if (occlusion && occlusion->method != OcclusionMethod::local)
        sum_ = occlusion->method == OcclusionMethod::positional ? native::OcclusionSum::positional
                                                                : native::OcclusionSum::rejecting;
    for (int level = finest_; occlusion && level < kLevelCount; ++level)
        rays_[static_cast<std::size_t>(level)] = occlusionRays(*occlusion, info, level);
}

void Occluder::setFunction(const TransferTable& table, const Optics& optics) {
    table_ = &table;
    optics_ = &optics;
    extinctions_->clear();
    if (withOthers_)
        withOthers_->clear();
    extinctionOf_.clear();
    emissionOf_.clear();
    const auto fill = [&](int lowest, int highest) {
        for (int stored = lowest; stored <= highest; ++stored) {
            extinctionOf_.push_back(occlusionExtinction(optics, static_cast<float>(stored)));
            if (gathersEmission())
                emissionOf_.push_back(sentBy(static_cast<float>(stored)));
        }
    };
    if (info_.type == ValueType::u8)
        fill(0, 255);
    else if (info_.type == ValueType::i16)
        fill(-32768, 32767);
    else if (info_.type == ValueType::u16)
        fill(0, 65535);
}

/// Light that tissue of a value sends, or its share of the light that it scatters.
glm::vec3 Occluder::sentBy(float stored) const {
    return static_cast<float>(strength_) *
           (scattered_ ? occlusionAlbedo(*optics_, stored) : occlusionEmission(*optics_, stored));
}

glm::ivec3 Occluder::mostReach() const {
    glm::ivec3 most(0);
    for (const OcclusionRays& rays : rays_)
        most = glm::max(most, rays.reach);
    return most;
}

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
    constexpr int kEdge = kChunkExtent + 2 * kAround;
    const glm::ivec3 near = first + room.reach - kAround; // from here on ranges are needed
    const glm::ivec3 from = glm::max(low, near), to = glm::min(high, near + kEdge);
    for (int z = from.z; z < to.z; ++z)
        for (int y = from.y; y < to.y; ++y)
            for (int run = 0; run < kRunsPerRow; ++run) {
                const int start = std::max(from.x, near.x + run * kRun);
                const int end = std::min(to.x, near.x + (run + 1) * kRun + 2 * kAround);
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
    const glm::ivec3 low = glm::max(sample - kAround, glm::ivec3(0)) << level;
    const glm::ivec3 high =
        glm::min((sample + glm::ivec3(kRun, 1, 1) + kAround) << level, info_.extentVoxels) - 1;
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
                const bool ranges = chunk.level == 0 &&
                                    glm::all(glm::lessThan(from, own + kChunkExtent + kAround)) &&
                                    glm::all(glm::greaterThan(to, own - kAround));
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
            for (int run = 0; run * kRun < samples.x; ++run) {
                bool wanted = bricks.empty();
                for (int x = run * kRun; !wanted && x < (run + 1) * kRun; x += edge)
                    wanted = bricks[linearIndex(glm::ivec3(x, y, z) / edge, glm::ivec3(along))] != 0;
                if (!wanted)
                    continue;
                const glm::ivec3 at(run * kRun, y, z);
                Range range;
                if (chunk.level > 0 || labels_)
                    range = rangeAround(own + at, chunk.level);
                else
                    for (int n = 0; n < (2 * kAround + 1) * (2 * kAround + 1); ++n) {
                        const std::size_t index =
                            runIndex(run, y + n % (2 * kAround + 1), z + n / (2 * kAround + 1));
                        range.add(room.low[index], room.high[index], kShowsFunction);
                    }
                if (range.low > range.high || isEmpty(range)) // all around is empty
                    continue;
                room.runs.push_back(
                    {at, linearIndex(at + room.reach, room.size), linearIndex(at, glm::ivec3(kChunkExtent))});
            }
}

void Occluder::occlude(const ChunkKey& chunk, const OcclusionRoom& found, BrickCache& cache,
                       OcclusionRoom& room) const {
    room.runs = found.runs;
    for (OcclusionRoom::Run& run : room.runs)
        run.from = linearIndex(run.at + room.reach, room.size);
    read(chunk, true, cache, room);
    occlude(chunk, room);
}

/// Of the runs' samples, from differences of the extinctions beside them.
void Occluder::findNormals(OcclusionRoom& room) const {
    const glm::mat3 toPatient(glm::transpose(glm::inverse(glm::dmat3(info_.patientFromVoxel))));
    const std::size_t pitch[3] = {1, static_cast<std::size_t>(room.size.x),
                                  static_cast<std::size_t>(room.size.x * room.size.y)};
    for (const OcclusionRoom::Run& run : room.runs)
        for (std::size_t n = 0; n < kRun; ++n) {
            const float* const at = room.extinction.data() + run.from + n;
            glm::vec3 rise(0);
            float sum = 0;
            for (int axis = 0; axis < 3; ++axis) {
                const float before = *(at - pitch[axis]), behind = *(at + pitch[axis]);
                rise[axis] = 0.5f * (behind - before);
                sum += before + behind;
            }
            const SurfaceAround surface = surfaceAround(rise, sum / 6, toPatient);
            for (int axis = 0; axis < 3; ++axis)
                room.normal[static_cast<std::size_t>(axis)][run.to + n] =
                    4 * surface.share * surface.normal[axis];
            room.rest[run.to + n] = 1 - surface.share;
            room.weights[run.to + n] = 0;
        }
}

void Occluder::occlude(const ChunkKey& chunk, OcclusionRoom& room) const {
    const OcclusionRays& rays = rays_[static_cast<std::size_t>(chunk.level)];
    TESSERA_CHECK(!rays.rays.empty() && glm::all(glm::lessThanEqual(rays.reach, room.reach)));
    std::fill(room.light.begin(), room.light.end(), 1.0f);
    for (const OcclusionRoom::Run& run : room.runs)
        std::fill_n(room.light.begin() + static_cast<std::ptrdiff_t>(run.to), kRun, 0.0f);
    for (std::vector<float>& got : room.shine)
        std::fill(got.begin(), got.end(), 0.0f);
    if (room.runs.empty())
        return;
    if (surfaces_)
        findNormals(room);

    const auto shareOf = [&](const OcclusionRay& ray) {
        return ray.part * (sum_ == native::OcclusionSum::local ? 0.5 / ray.steps : 1.0);
    };
    // Rays of one length of step read the same opacities.
    const std::int32_t pitch[3] = {1, room.size.x, room.size.x * room.size.y};
    std::vector<native::OcclusionStep> steps;
    std::vector<native::OcclusionPath> paths;
    for (std::size_t first = 0; first < rays.rays.size();) {
        std::size_t end = first;
        while (end < rays.rays.size() && rays.rays[end].stepMm <= rays.rays[first].stepMm * (1 + 1e-9))
            ++end;
        steps.clear();
        paths.clear();
        for (std::size_t r = first; r < end; ++r)
            for (int n = 0; n <= rays.rays[r].steps; ++n) {
                const OcclusionRay& ray = rays.rays[r];
                const glm::dvec3 at = ray.step * double(ray.skipped + n);
                const int a = (ray.axis + 1) % 3, b = (ray.axis + 2) % 3;
                glm::ivec3 whole(glm::floor(at));
                whole[ray.axis] = static_cast<int>(std::lround(at[ray.axis]));
                const auto fa = static_cast<float>(at[a] - whole[a]),
                           fb = static_cast<float>(at[b] - whole[b]);
                steps.push_back({whole.x * pitch[0] + whole.y * pitch[1] + whole.z * pitch[2],
                                 {(1 - fa) * (1 - fb), fa * (1 - fb), (1 - fa) * fb, fa * fb}});
            }
        const native::OcclusionStep* next = steps.data();
        for (std::size_t r = first; r < end; ++r) {
            const OcclusionRay& ray = rays.rays[r];
            const glm::vec3 to(ray.direction);
            paths.push_back({next,
                             ray.steps + 1,
                             pitch[(ray.axis + 1) % 3],
                             pitch[(ray.axis + 2) % 3],
                             static_cast<float>(shareOf(ray)),
                             static_cast<float>(ray.part),
                             {to.x, to.y, to.z}});
            next += ray.steps + 1;
        }
        for (std::size_t row = 0; row < room.rowShows.size(); ++row) {
            const std::size_t at = row * static_cast<std::size_t>(room.size.x);
            if (room.rowShows[row] != 0)
                target_.opacities(room.extinction.data() + at, room.size.x,
                                  static_cast<float>(rays.rays[first].stepMm), room.opacity.data() + at);
            else if (room.rowIsSet[row] != 0)
                std::fill_n(room.opacity.begin() + static_cast<std::ptrdiff_t>(at), room.size.x, 0.0f);
            room.rowIsSet[row] = room.rowShows[row];
        }
        const auto count = static_cast<int>(paths.size());
        for (const OcclusionRoom::Run& run : room.runs) {
            const float* const opacity = room.opacity.data() + run.from;
            float* const light = room.light.data() + run.to;
            if (!gathersEmission()) {
                const native::OcclusionNormals normals =
                    surfaces_ ? native::OcclusionNormals{{room.normal[0].data() + run.to,
                                                          room.normal[1].data() + run.to,
                                                          room.normal[2].data() + run.to},
                                                         room.rest.data() + run.to,
                                                         room.weights.data() + run.to}
                              : native::OcclusionNormals{};
                target_.occlude(opacity, paths.data(), count, sum_, surfaces_ ? &normals : nullptr, light);
                continue;
            }
            const float* const sent[3] = {room.emission[0].data() + run.from,
                                          room.emission[1].data() + run.from,
                                          room.emission[2].data() + run.from};
            float* const got[3] = {room.shine[0].data() + run.to, room.shine[1].data() + run.to,
                                   room.shine[2].data() + run.to};
            target_.occludeAndShine(opacity, sent, paths.data(), count, light, got);
        }
        first = end;
    }
    for (const OcclusionRoom::Run& run : room.runs)
        for (std::size_t n = run.to; surfaces_ && n < run.to + kRun; ++n)
            room.light[n] = room.weights[n] > 0 ? room.light[n] / room.weights[n] : 1;
}

} // namespace tessera
