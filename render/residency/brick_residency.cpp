// render/residency/brick_residency.cpp: see brick_residency.h.
#include "render/residency/brick_residency.h"

#include "bricking/cache/brick_cache.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"

#include <algorithm>
#include <array>
#include <bit>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

namespace tessera {
namespace {

/// Chunks whose bricks are put together, by several threads.
constexpr std::size_t kChunksAtOnce = 16;

/// Visits some chunks at once, in batches that the cache can pin while others are decoded, until visit
/// returns false.
template <typename Visit>
void forEachChunks(BrickCache& cache, const std::vector<ChunkKey>& keys, const Visit& visit) {
    const std::size_t batch = std::max<std::size_t>(1, cache.pinnableChunks() / 2);
    for (std::size_t first = 0; first < keys.size(); first += batch) {
        const std::size_t count = std::min(batch, keys.size() - first);
        auto futures = cache.request(std::span(keys).subspan(first, count));
        for (std::size_t i = 0; i < count; i += kChunksAtOnce) {
            std::vector<ChunkPointer> chunks; // pinned until they are put
            for (std::size_t k = i; k < std::min(i + kChunksAtOnce, count); ++k)
                chunks.push_back(std::exchange(futures[k], {}).get());
            if (!visit(std::span(keys).subspan(first + i, chunks.size()), chunks))
                return;
        }
    }
}

constexpr std::uint32_t kEntryValue = 0x80000000u, kEntryAbsent = 0x40000000u; // as in sampler_atlas.glsl

} // namespace

BrickResidency::BrickResidency(const VolumeInfo& info, const Selection& selection, std::size_t pages,
                               const TextureLimits& limits, std::vector<Plane*> planes, MemoryBudget& ram)
    : bricks_(selection.bricks), box_(atlasPages(std::max<std::size_t>(1, pages), info.type, limits)),
      pages_(std::max<std::size_t>(1, pages)), planes_(std::move(planes)), allocator_(box_),
      entriesCharge_(
          ram.charge(indexBytes(selection.bricks) + cellCount(selection.bricks), "the brick index")),
      entries_(cellCount(selection.bricks), BrickEntry(kEntryAbsent, 0)),
      levels_(cellCount(selection.bricks), Selection::kEmpty) {
    adopt(selection);
}

void BrickResidency::adopt(const Selection& selection) {
    TESSERA_CHECK(selection.bricks == bricks_);
    for (std::size_t b = 0; b < entries_.size(); ++b) {
        const std::uint8_t level = selection.levels[b];
        if (isResident(b)) {
            if (levels_[b] == level)
                continue;
            evict(b);
        }
        levels_[b] = level;
        entries_[b] = level + 1 < kLevelCount
                          ? BrickEntry(kEntryAbsent, 0)
                          : BrickEntry(kEntryValue, std::bit_cast<std::uint32_t>(selection.means[b]));
    }
    publish();
}

void BrickResidency::publish() {
    for (Plane* plane : planes_)
        plane->publish(entries_);
}

void BrickResidency::finish() {
    for (Plane* plane : planes_)
        plane->finish();
}

namespace {

AtlasSlot decoded(const BrickEntry& entry, int level) {
    const auto part = [](std::uint32_t word, int shift, std::uint32_t mask) {
        return static_cast<int>((word >> shift) & mask);
    };
    return {{part(entry.x, 0, 1023), part(entry.x, 10, 1023), part(entry.x, 20, 1023)},
            {part(entry.y, 0, 31), part(entry.y, 5, 31), part(entry.y, 10, 31)},
            level};
}

} // namespace

bool BrickResidency::isResident(std::size_t brick) const {
    return (entries_[brick].x & (kEntryValue | kEntryAbsent)) == 0;
}

std::optional<int> BrickResidency::residentLevel(std::size_t brick) const {
    return isResident(brick) ? std::optional<int>(levels_[brick]) : std::nullopt;
}

std::optional<AtlasSlot> BrickResidency::slotOf(std::size_t brick) const {
    return isResident(brick) ? std::optional(decoded(entries_[brick], levels_[brick])) : std::nullopt;
}

void BrickResidency::evict(std::size_t brick) {
    allocator_.release(decoded(entries_[brick], levels_[brick]));
    entries_[brick] = {kEntryAbsent, 0};
}

void BrickResidency::load(BrickCache& cache, Work& work) {
    std::vector<std::size_t> bricks;
    for (std::size_t b = 0; b < entries_.size(); ++b)
        if (levels_[b] + 1 < kLevelCount)
            bricks.push_back(b);
    serve(bricks, cache, work);
}

void BrickResidency::serve(std::span<const std::size_t> bricks, BrickCache& cache, Work& work) {
    std::vector<std::uint8_t> keep(entries_.size(), 0);
    std::vector<std::size_t> missing;
    for (const std::size_t b : bricks) {
        keep[b] = 1;
        if (!isResident(b))
            missing.push_back(b);
    }
    // Others are evicted only when their memory is needed, then all at once, because a page holds bricks of
    // one level. If sparse pages still block, everything is repacked.
    const auto evictUnless = [&](bool kept) {
        for (std::size_t b = 0; b < entries_.size(); ++b)
            if (isResident(b) && !(kept && keep[b]))
                evict(b);
        missing.clear();
        for (const std::size_t b : bricks)
            if (!isResident(b))
                missing.push_back(b);
    };
    if (!loadBricks(missing, cache, work)) {
        evictUnless(true);
        if (!loadBricks(missing, cache, work)) {
            evictUnless(false);
            TESSERA_CHECK(loadBricks(missing, cache, work));
        }
    }
    publish();
}

bool BrickResidency::loadBricks(std::vector<std::size_t> bricks, BrickCache& cache, Work& work) {
    const auto key = [&](std::size_t b) { return chunkOf(b, levels_[b], bricks_); };
    // Coarse levels first: they are few, and most of the picture.
    std::sort(bricks.begin(), bricks.end(), [&](std::size_t a, std::size_t b) {
        const ChunkKey ka = key(a), kb = key(b);
        return ka != kb ? std::tie(kb.level, ka.k, ka.j, ka.i) < std::tie(ka.level, kb.k, kb.j, kb.i) : a < b;
    });
    std::vector<ChunkKey> keys;
    for (const std::size_t b : bricks)
        if (const ChunkKey mine = key(b); keys.empty() || keys.back() != mine)
            keys.push_back(mine);
    std::size_t next = 0;
    bool room = true;
    std::vector<BrickInSlot> placed;
    forEachChunks(cache, keys, [&](std::span<const ChunkKey> some, std::span<const ChunkPointer> chunks) {
        checkInterrupted();
        placed.clear();
        for (std::size_t n = 0; n < some.size(); ++n)
            for (; room && next < bricks.size() && key(bricks[next]) == some[n]; ++next)
                room = take(bricks[next], *chunks[n], placed);
        put(placed, work);
        return room;
    });
    finish();
    return room;
}

std::size_t BrickResidency::place(std::span<const BrickToPlace> bricks, Work& work) {
    std::size_t placed = 0;
    for (; placed < bricks.size(); ++placed) {
        const BrickToPlace& b = bricks[placed];
        TESSERA_CHECK(b.level + 1 < kLevelCount && b.chunk);
        const BrickEntry entry = entries_[b.brick];
        const std::uint8_t level = levels_[b.brick];
        const bool resident = isResident(b.brick);
        levels_[b.brick] = static_cast<std::uint8_t>(b.level);
        std::vector<BrickInSlot> one;
        if (!take(b.brick, *b.chunk, one)) {
            levels_[b.brick] = level;
            break;
        }
        put(one, work);
        if (resident)
            allocator_.release(decoded(entry, level));
    }
    finish();
    return placed;
}

void BrickResidency::dropToMean(std::size_t brick, float mean) {
    if (isResident(brick))
        evict(brick);
    levels_[brick] = kLevelCount - 1;
    entries_[brick] = {kEntryValue, std::bit_cast<std::uint32_t>(mean)};
}

std::vector<std::size_t> BrickResidency::bricksOfSparsestPage() const {
    const glm::ivec3 pages = box_;
    std::vector<std::uint16_t> used(cellCount(pages));
    std::vector<std::uint8_t> level(used.size());
    const auto pageOf = [&](std::size_t b) {
        return linearIndex(decoded(entries_[b], levels_[b]).page, pages);
    };
    for (std::size_t b = 0; b < entries_.size(); ++b)
        if (isResident(b)) {
            ++used[pageOf(b)];
            level[pageOf(b)] = levels_[b];
        }
    std::array<std::size_t, kLevelCount> room{}; // slots of pages in use
    for (std::size_t page = 0; page < used.size(); ++page)
        if (used[page] > 0)
            room[level[page]] += PageAllocator::slotsPerPage(level[page]) - used[page];
    std::size_t best = used.size();
    for (std::size_t page = 0; page < used.size(); ++page) {
        const std::size_t own = PageAllocator::slotsPerPage(level[page]) - used[page];
        if (used[page] > 0 && room[level[page]] - own >= used[page] &&
            (best == used.size() || used[page] < used[best]))
            best = page;
    }
    std::vector<std::size_t> bricks;
    for (std::size_t b = 0; best < used.size() && b < entries_.size(); ++b)
        if (isResident(b) && pageOf(b) == best)
            bricks.push_back(b);
    return bricks;
}

/// Gives a brick a slot. False if none is left.
bool BrickResidency::take(std::size_t brick, const Chunk& chunk, std::vector<BrickInSlot>& placed) {
    const int level = levels_[brick], edge = kBrickExtent >> level;
    const auto slot = allocator_.allocate(level);
    if (!slot)
        return false;
    const glm::ivec3 inChunk = (gridPosition(brick, bricks_) & ((1 << level) - 1)) * edge;
    placed.push_back({*slot, {chunk, inChunk, edge, brick}});
    const glm::uvec3 page(slot->page), place(slot->slot);
    entries_[brick] = {page.x | page.y << 10 | page.z << 20, place.x | place.y << 5 | place.z << 10};
    return true;
}

void BrickResidency::put(std::span<const BrickInSlot> placed, Work& work) {
    for (Plane* plane : planes_)
        plane->putAll(placed, work);
    work.bricksUploaded += placed.size();
}

} // namespace tessera
