// render/backends/native/host_plane.cpp: see host_plane.h.
#include "render/backends/native/host_plane.h"

#include "core/base/error.h"
#include "core/base/threads.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <new>
#include <sys/mman.h>

namespace tessera {
namespace {

using native::PacketBrick;
using native::SampleKind;

constexpr std::uint32_t kEntryValue = 0x80000000u, kEntryAbsent = 0x40000000u; // brick_residency.h
constexpr std::size_t kHugePage = std::size_t{2} << 20;
constexpr int kBias = 8; // of a box's bytes

SampleKind kindOf(ValueType type) {
    switch (type) {
    case ValueType::i16:
        return SampleKind::i16;
    case ValueType::u8: // as 16 bits, so that two samples are one load
    case ValueType::u16:
        return SampleKind::u16;
    case ValueType::f32:
        break;
    }
    return SampleKind::f32;
}

std::size_t sampleBytes(SampleKind kind) {
    return kind == SampleKind::f32 ? 4 : 2;
}

std::uint32_t packed(const glm::ivec3& cell, std::uint32_t top) {
    const glm::uvec3 c(cell + kBias);
    return c.x | c.y << 8 | c.z << 16 | top << 24;
}

glm::ivec3 pageOf(const BrickEntry& entry) {
    return {entry.x & 1023, (entry.x >> 10) & 1023, (entry.x >> 20) & 1023};
}
glm::ivec3 slotOf(const BrickEntry& entry) {
    return {entry.y & 31, (entry.y >> 5) & 31, (entry.y >> 10) & 31};
}

} // namespace

void HostPlane::Free::operator()(std::byte* bytes) const {
    std::free(bytes);
}

HostPlane::HostPlane(const VolumeInfo& info, std::size_t pages, const TextureLimits& limits, int threads,
                     MemoryBudget& memory)
    : HostPlane(info, info.type, "the bricks", pages, limits, threads, memory) {}

HostPlane::HostPlane(const VolumeInfo& info, ValueType type, const char* what, std::size_t pages,
                     const TextureLimits& limits, int threads, MemoryBudget& memory)
    : info_(info), type_(type), kind_(kindOf(type)), grid_(brickGrid(info.extentVoxels)),
      box_(atlasPages(std::max<std::size_t>(1, pages), info.type, limits)), edge_(limits.pageEdge),
      threads_(threads) {
    TESSERA_CHECK(box_.x > 0);
    const std::size_t count = cellCount(box_), edge = static_cast<std::size_t>(edge_);
    const std::size_t bytes = count * edge * edge * edge * sampleBytes(kind_);
    charge_ = memory.charge(bytes + cellCount(grid_) * limits.indexEntryBytes, what);
    const std::size_t around = kAround * sampleBytes(kind_), needed = around + bytes + around;
    const std::size_t whole = (needed + kHugePage - 1) / kHugePage * kHugePage;
    auto* const room = static_cast<std::byte*>(bytes < kHugePage ? std::malloc(needed)
                                                                 : std::aligned_alloc(kHugePage, whole));
    if (!room)
        throw std::bad_alloc();
    room_.reset(room);
    samples_ = room + around;
    if (bytes >= kHugePage)
        madvise(room, whole,
                MADV_HUGEPAGE); // fewer faults and fewer misses; a wish, so its result does not matter
    levelOfPage_.assign(count, 0);
    putInPage_.assign(count, 0);
    entries_.assign(cellCount(grid_), BrickEntry(kEntryAbsent, 0));
    filled_ = entries_;
    bricks_.resize(entries_.size());
    hasGhostLayer_.assign(entries_.size(), 0);
}

namespace {

template <typename Stored, typename Sample>
void copyBrick(const BrickSamples& from, Sample* to, std::size_t row, std::size_t slice) {
    const auto* const stored = reinterpret_cast<const Stored*>(from.chunk.bytes.get());
    const auto edge = static_cast<std::size_t>(from.edge);
    for (std::size_t z = 0; z < edge; ++z)
        for (std::size_t y = 0; y < edge; ++y) {
            const Stored* const line =
                stored + linearIndex(from.first + glm::ivec3(0, static_cast<int>(y), static_cast<int>(z)),
                                     glm::ivec3(kChunkExtent));
            std::copy(line, line + edge, to + z * slice + y * row);
        }
}

} // namespace

void HostPlane::put(const AtlasSlot& slot, const BrickSamples& samples, Work& work) {
    const std::size_t page = linearIndex(slot.page, box_), edge = static_cast<std::size_t>(edge_);
    // Slots of one page are put by several threads, all with the same level.
    std::atomic_ref(levelOfPage_[page])
        .store(static_cast<std::uint8_t>(slot.level), std::memory_order_relaxed);
    std::atomic_ref(putInPage_[page]).store(1, std::memory_order_relaxed);
    const auto row = static_cast<std::size_t>(rowPitch(slot.level)), slice = row * row;
    std::size_t first = page * edge * edge * edge;
    if (slot.level == 0)
        first += edge_ > kBrickExtent ? kGhostBefore * (slice + row + 1) : 0;
    else
        first += linearIndex(slot.slot, glm::ivec3(1 << slot.level)) * slice * row;
    switch (type_) {
    case ValueType::u8:
        copyBrick<std::uint8_t>(samples, at<std::uint16_t>(static_cast<std::uint32_t>(first)), row, slice);
        break;
    case ValueType::i16:
    case ValueType::u16:
        copyBrick<std::uint16_t>(samples, at<std::uint16_t>(static_cast<std::uint32_t>(first)), row, slice);
        break;
    case ValueType::f32:
        copyBrick<float>(samples, at<float>(static_cast<std::uint32_t>(first)), row, slice);
        break;
    }
    work.bytesUploaded += static_cast<std::size_t>(samples.edge) * static_cast<std::size_t>(samples.edge) *
                          static_cast<std::size_t>(samples.edge) * sampleBytes(kind_);
}

void HostPlane::putAll(std::span<const BrickInSlot> bricks, Work& work) {
    std::atomic<std::size_t> bytes{0};
    parallelFor(bricks.size(), threads_, [&](std::size_t n) {
        Work own;
        put(bricks[n].slot, bricks[n].samples, own);
        bytes.fetch_add(own.bytesUploaded, std::memory_order_relaxed);
    });
    work.bytesUploaded += bytes;
}

void HostPlane::publish(std::span<const BrickEntry> entries) {
    settled_ = false;
    std::copy(entries.begin(), entries.end(), entries_.begin());
}

const void* HostPlane::samplesOf(const PacketBrick& brick) const {
    return samples_ + brick.base * sampleBytes(kind_);
}

float HostPlane::sampleAt(const PacketBrick& brick, int level, const glm::ivec3& i) const {
    const glm::ivec3 in = i & ((kBrickExtent >> level) - 1);
    const std::size_t n =
        brick.base + static_cast<std::size_t>((in.z * rowPitch(level) + in.y) * rowPitch(level) + in.x);
    switch (kind_) {
    case SampleKind::i16:
        return reinterpret_cast<const std::int16_t*>(samples_)[n];
    case SampleKind::u16:
        return reinterpret_cast<const std::uint16_t*>(samples_)[n];
    case SampleKind::f32:
        break;
    }
    return reinterpret_cast<const float*>(samples_)[n];
}

void HostPlane::settle(const LevelMap* map, int level) {
    if (settled_)
        return;
    // Bricks whose samples are others, or in another place, than when ghost layers were filled.
    std::vector<std::uint8_t> stale(entries_.size(), 0);
    for (std::size_t b = 0; b < entries_.size(); ++b) {
        const BrickEntry& entry = entries_[b];
        PacketBrick& brick = bricks_[b];
        const bool isHere = (entry.x & (kEntryValue | kEntryAbsent)) == 0;
        bool isNew = entry != filled_[b];
        std::uint32_t state = PacketBrick::kAbsent;
        if (isHere) {
            const std::size_t page = linearIndex(pageOf(entry), box_), edge = static_cast<std::size_t>(edge_);
            state = levelOfPage_[page];
            const auto own = static_cast<int>(state);
            const auto row = static_cast<std::uint32_t>(rowPitch(own));
            brick.base = static_cast<std::uint32_t>(page * edge * edge * edge);
            if (own == 0)
                brick.base += edge_ > kBrickExtent ? kGhostBefore * (row * row + row + 1) : 0;
            else
                brick.base += static_cast<std::uint32_t>(linearIndex(slotOf(entry), glm::ivec3(1 << own))) *
                              row * row * row;
            isNew = isNew || putInPage_[page] != 0;
        } else if (entry.x & kEntryValue) {
            state = PacketBrick::kValue;
            brick.mean = std::bit_cast<float>(entry.y);
        }
        brick.low = packed(glm::ivec3(1), state); // no cell, until setBox()
        brick.high = packed(glm::ivec3(0), 0);
        if (isNew && edge_ > kBrickExtent) {
            const glm::ivec3 at = gridPosition(b, grid_);
            const glm::ivec3 low = glm::max(at - 1, glm::ivec3(0)), high = glm::min(at + 1, grid_ - 1);
            for (int z = low.z; z <= high.z; ++z)
                for (int y = low.y; y <= high.y; ++y)
                    for (int x = low.x; x <= high.x; ++x)
                        stale[linearIndex({x, y, z}, grid_)] = 1;
        }
    }
    constexpr std::size_t kAtATime = 64;
    const auto forEachBrick = [&](const auto& visit) {
        parallelFor((entries_.size() + kAtATime - 1) / kAtATime, threads_, [&](std::size_t turn) {
            for (std::size_t b = turn * kAtATime; b < std::min(entries_.size(), (turn + 1) * kAtATime); ++b)
                visit(b);
        });
    };
    // One after the other: ghost layers read data that boxes are written beside.
    forEachBrick([&](std::size_t b) {
        if (stale[b])
            hasGhostLayer_[b] = fillGhostLayer(b) ? 1 : 0;
    });
    forEachBrick([&](std::size_t b) { setBox(b, map, level); });
    filled_ = entries_;
    settled_ = true;
    std::fill(putInPage_.begin(), putInPage_.end(), std::uint8_t{0});
}

bool HostPlane::fillGhostLayer(std::size_t brick) {
    if ((bricks_[brick].low >> 24) != 0)
        return false;
    const glm::ivec3 at = gridPosition(brick, grid_);
    switch (kind_) {
    case SampleKind::i16:
        return fillGhostLayerOf<std::int16_t>(at);
    case SampleKind::u16:
        return fillGhostLayerOf<std::uint16_t>(at);
    case SampleKind::f32:
        break;
    }
    return fillGhostLayerOf<float>(at);
}

/// False where a neighbour has no samples of level 0 to give.
template <typename Sample> bool HostPlane::fillGhostLayerOf(const glm::ivec3& brick) {
    const glm::ivec3 first = brick * kBrickExtent, last = info_.extentVoxels - 1;
    const std::int64_t row = edge_, slice = row * row;
    struct Neighbour {
        const Sample* samples = nullptr; // null: all of one value
        Sample value{};
    };
    Neighbour around[27];
    for (int n = 0; n < 27; ++n) {
        const glm::ivec3 side = brick + glm::ivec3(n % 3, n / 3 % 3, n / 9) - 1;
        if (glm::any(glm::lessThan(side, glm::ivec3(0))) || glm::any(glm::greaterThanEqual(side, grid_)))
            continue; // never read: positions are clamped to the volume
        const PacketBrick& other = bricks_[linearIndex(side, grid_)];
        const std::uint32_t state = other.low >> 24;
        Neighbour& mine = around[n];
        if (state == 0) {
            mine.samples = at<Sample>(other.base);
        } else if (state == PacketBrick::kValue) {
            if (!(other.mean >= static_cast<float>(std::numeric_limits<Sample>::lowest()) &&
                  other.mean <= static_cast<float>(std::numeric_limits<Sample>::max())))
                return false;
            mine.value = static_cast<Sample>(other.mean);
            if (static_cast<float>(mine.value) != other.mean)
                return false;
        } else {
            return false;
        }
    }
    Sample* const own = at<Sample>(bricks_[linearIndex(brick, grid_)].base);
    const glm::ivec3 inside =
        glm::min(last - first, glm::ivec3(kBrickExtent - 1)); // own samples that are the volume's
    for (int z = -kGhostBefore; z < kBrickExtent + kGhostBehind; ++z)
        for (int y = -kGhostBefore; y < kBrickExtent + kGhostBehind; ++y) {
            const glm::ivec2 from =
                glm::clamp(glm::ivec2(first.y + y, first.z + z), glm::ivec2(0), glm::ivec2(last.y, last.z));
            const glm::ivec2 source = from >> 5;
            const bool isOwn = y >= 0 && z >= 0 && y <= inside.y && z <= inside.z;
            const int neighbour =
                3 * (source.x - brick.y + 1) + 9 * (source.y - brick.z + 1) + 1; // plus -1, 0, 1
            const std::int64_t line = (from.y & 31) * slice + (from.x & 31) * row;
            Sample* const to = own + z * slice + y * row;
            const auto sample = [&](int x) {
                const int at = std::clamp(first.x + x, 0, last.x);
                const Neighbour& n = around[neighbour + (at >> 5) - brick.x];
                return n.samples ? n.samples[line + (at & 31)] : n.value;
            };
            for (int x = -kGhostBefore; x < 0; ++x)
                to[x] = sample(x);
            if (!isOwn) {
                const Neighbour& n = around[neighbour];
                if (n.samples)
                    std::copy(n.samples + line, n.samples + line + inside.x + 1, to);
                else
                    std::fill(to, to + inside.x + 1, n.value);
            }
            for (int x = inside.x + 1; x < kBrickExtent + kGhostBehind; ++x)
                to[x] = sample(x);
        }
    return true;
}

namespace {

/// True if the field in a brick of level 0 and around it is plain interpolation of level 0.
bool isPlainAround(const LevelMap& map, const glm::ivec3& brick) {
    for (int n = 0; n < 8; ++n) {
        const BrickCorner& corner = map.at(brick + glm::ivec3(n & 1, (n >> 1) & 1, n >> 2));
        if (!corner.agree() || corner.commonLevel() != 0)
            return false;
    }
    return true;
}

} // namespace

void HostPlane::setBox(std::size_t b, const LevelMap* map, int level) {
    PacketBrick& brick = bricks_[b];
    const std::uint32_t state = brick.low >> 24;
    if (state >= PacketBrick::kValue)
        return;
    const auto own = static_cast<int>(state);
    const glm::ivec3 at = gridPosition(b, grid_);
    TESSERA_CHECK(map || own == level);
    if (own == 0 && hasGhostLayer_[b] && (!map || isPlainAround(*map, at))) {
        brick.low = packed(glm::ivec3(-kGhostBefore), state);
        TESSERA_CHECK(brick.low == kLowWithGhost);
        brick.high = packed(glm::ivec3(kBrickExtent + kGhostBehind - 1), 0);
        return;
    }
    glm::ivec3 low(0);
    const glm::ivec3 extent = levelExtent(info_.extentVoxels, own), first = at * (kBrickExtent >> own);
    glm::ivec3 high = glm::min(glm::ivec3(kBrickExtent >> own), extent - first) - 1;
    // Other bricks' weight ends half a sample of some level from the face. Only where that may be a coarser
    // one's does it reach between the brick's samples, but from across an edge: PacketField::facts.
    if (map && map->edgeFunction == EdgeFunction::maximum) {
        const std::uint32_t facts = map->facts[b];
        for (int axis = 0; axis < 3; ++axis)
            for (int side = 0; side < 2; ++side) {
                const int code = static_cast<int>((facts >> (3 + 3 * (axis + 3 * side))) & 7u);
                if (code >= 6)
                    continue;
                const double reach = std::ldexp(0.5, code - own) - 0.5; // samples from the outermost one
                const int whole = static_cast<int>(std::ceil(std::max(0.0, reach)));
                if (side == 0)
                    low[axis] = std::max(low[axis], whole);
                else
                    high[axis] = std::min(high[axis], (kBrickExtent >> own) - 1 - whole);
            }
    }
    if (glm::any(glm::lessThanEqual(high, low)))
        return;
    brick.low = packed(low, state);
    brick.high = packed(high, 0);
}

} // namespace tessera
