// render/atlas.cpp: see atlas.h.
#include "render/atlas.h"

#include "core/error.h"
#include "core/interrupt.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <tuple>
#include <vector>

namespace tessera {
namespace {

constexpr std::uint32_t kEntryValue = 0x80000000u, kEntryAbsent = 0x40000000u; // as in sampler_atlas.glsl

template <typename Stored, typename Texel, typename Convert>
void convert(const std::byte* stored, std::size_t count, std::byte* texels, Convert convertOne) {
    for (std::size_t i = 0; i < count; ++i) {
        Stored value;
        std::memcpy(&value, stored + i * sizeof(Stored), sizeof(Stored));
        const Texel texel = convertOne(value);
        std::memcpy(texels + i * sizeof(Texel), &texel, sizeof(Texel));
    }
}

/// Chunks in batches the cache can pin at once while others are decoded, until visit says false.
template <typename Visit>
void forEachChunk(BrickCache& cache, const std::vector<ChunkKey>& keys, const Visit& visit) {
    const std::size_t batch = std::max<std::size_t>(1, cache.pinnableChunks() / 2);
    for (std::size_t first = 0; first < keys.size(); first += batch) {
        const std::size_t count = std::min(batch, keys.size() - first);
        auto futures = cache.request(std::span(keys).subspan(first, count));
        for (std::size_t i = 0; i < count; ++i) {
            if (!visit(keys[first + i], *futures[i].get()))
                return;
            futures[i] = {}; // unpin
        }
    }
}

} // namespace

std::size_t texelBytes(ValueType type) {
    return type == ValueType::f32 ? 4 : 2;
}

TexelFormat texelFormat(ValueType type) {
    switch (type) {
    case ValueType::i16:
        return {GL_R16, GL_RED, GL_UNSIGNED_SHORT, true, -32768.0f};
    case ValueType::u8:
    case ValueType::u16:
        return {GL_R16, GL_RED, GL_UNSIGNED_SHORT, true, 0.0f};
    case ValueType::f32:
        break;
    }
    return {GL_R32F, GL_RED, GL_FLOAT, false, 0.0f};
}

void toTexels(ValueType type, const std::byte* stored, std::size_t count, std::byte* texels) {
    switch (type) {
    case ValueType::u8:
        return convert<std::uint8_t, std::uint16_t>(
            stored, count, texels, [](std::uint8_t v) { return static_cast<std::uint16_t>(v); });
    case ValueType::i16: // two's complement plus 32768 is a flip of the sign bit
        return convert<std::uint16_t, std::uint16_t>(
            stored, count, texels, [](std::uint16_t v) { return static_cast<std::uint16_t>(v ^ 0x8000u); });
    case ValueType::u16:
        std::memcpy(texels, stored, count * 2);
        return;
    case ValueType::f32:
        std::memcpy(texels, stored, count * 4);
        return;
    }
}

std::size_t pagesFor(const std::array<std::size_t, kLevelCount + 1>& counts) {
    std::size_t pages = 0;
    for (int level = 0; level + 1 < kLevelCount; ++level)
        pages += PageAllocator::pagesFor(counts[static_cast<std::size_t>(level)], level);
    return pages;
}

glm::ivec3 atlasPages(std::size_t pages, ValueType type, const TextureLimits& limits) {
    const std::size_t wanted = std::max<std::size_t>(1, pages);
    const std::size_t pageBytes = 32768 * texelBytes(type);
    const std::size_t edge =
        std::min<std::size_t>(static_cast<std::size_t>(limits.maxExtent / kBrickExtent), 1024);
    if (wanted > limits.maxBytes / pageBytes)
        return glm::ivec3(0);
    // Few pages are wasted by trying every x up to a square and every y up to a cube; thin boxes are avoided.
    glm::ivec3 best(0);
    std::size_t bestPages = std::numeric_limits<std::size_t>::max();
    const std::size_t cube = static_cast<std::size_t>(std::ceil(std::cbrt(static_cast<double>(wanted))));
    for (std::size_t x = 1; x <= std::min(edge, 2 * cube); ++x)
        for (std::size_t y = 1; y <= std::min(edge, 2 * cube); ++y) {
            const std::size_t z = (wanted + x * y - 1) / (x * y);
            if (z > edge || x * y * z > limits.maxBytes / pageBytes)
                continue;
            const bool rounder =
                x * y * z == bestPages && x + y + z < static_cast<std::size_t>(best.x + best.y + best.z);
            if (x * y * z < bestPages || rounder) {
                bestPages = x * y * z;
                best = glm::ivec3(static_cast<int>(x), static_cast<int>(y), static_cast<int>(z));
            }
        }
    return best;
}

std::size_t atlasBytes(std::size_t pages, ValueType type, const TextureLimits& limits) {
    const glm::ivec3 box = atlasPages(pages, type, limits);
    return box.x == 0 ? std::numeric_limits<std::size_t>::max() : cellCount(box) * 32768 * texelBytes(type);
}

std::size_t pagesThatFit(std::size_t bytes, ValueType type, const TextureLimits& limits) {
    std::size_t pages = std::min(bytes, limits.maxBytes) / atlasBytes(1, type, TextureLimits{});
    while (pages > 0 && atlasBytes(pages, type, limits) > bytes)
        --pages;
    return pages;
}

Atlas::Atlas(const VolumeInfo& info, const Selection& selection, std::size_t pages,
             const TextureLimits& limits, Ledger& gpu, Ledger& ram)
    : bricks_(selection.bricks), info_(info), pages_(std::max<std::size_t>(1, pages)),
      format_(texelFormat(info.type)), allocator_(atlasPages(pages_, info.type, limits)),
      entriesCharge_(
          ram.charge(indexBytes(selection.bricks) + cellCount(selection.bricks), "the brick index")),
      entries_(cellCount(selection.bricks), glm::uvec2(kEntryAbsent, 0)),
      levels_(cellCount(selection.bricks), Selection::kEmpty) {
    const glm::ivec3 box = atlasPages(pages_, info.type, limits);
    TESSERA_CHECK(box.x > 0);
    voxels_ = GlTexture3d(format_.internal, box * kBrickExtent, texelBytes(info.type), GL_LINEAR, gpu,
                          "the brick atlas");
    index_ = GlTexture3d(GL_RG32UI, selection.bricks, 8, GL_NEAREST, gpu, "the brick index");
    adopt(selection);
}

void Atlas::adopt(const Selection& selection) {
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
                          ? glm::uvec2(kEntryAbsent, 0)
                          : glm::uvec2(kEntryValue, std::bit_cast<std::uint32_t>(selection.means[b]));
    }
    writeIndex();
}

std::size_t Atlas::stagingBytes(const VolumeInfo& info) {
    return cellCount(glm::ivec3(kBrickExtent)) * texelBytes(info.type) +
           2 * indexBytes(brickGrid(info.extentVoxels)) + cellCount(brickGrid(info.extentVoxels));
}

void Atlas::writeIndex() {
    index_.upload(glm::ivec3(0), bricks_, GL_RG_INTEGER, GL_UNSIGNED_INT, entries_.data());
    glFinish(); // the driver may still hold copies of what was handed over
}

ChunkKey chunkOf(std::size_t brick, int level, const glm::ivec3& bricks) {
    const glm::ivec3 chunk = gridPosition(brick, bricks) >> level;
    return {level, chunk.x, chunk.y, chunk.z};
}

namespace {

AtlasSlot slotOf(const glm::uvec2& entry, int level) {
    const auto part = [](std::uint32_t word, int shift, std::uint32_t mask) {
        return static_cast<int>((word >> shift) & mask);
    };
    return {{part(entry.x, 0, 1023), part(entry.x, 10, 1023), part(entry.x, 20, 1023)},
            {part(entry.y, 0, 31), part(entry.y, 5, 31), part(entry.y, 10, 31)},
            level};
}

} // namespace

bool Atlas::isResident(std::size_t brick) const {
    return (entries_[brick].x & (kEntryValue | kEntryAbsent)) == 0;
}

std::optional<int> Atlas::residentLevel(std::size_t brick) const {
    return isResident(brick) ? std::optional<int>(levels_[brick]) : std::nullopt;
}

void Atlas::evict(std::size_t brick) {
    allocator_.release(slotOf(entries_[brick], levels_[brick]));
    entries_[brick] = {kEntryAbsent, 0};
}

void Atlas::load(BrickCache& cache, Ledger& ram, Work& work) {
    std::vector<std::size_t> bricks;
    for (std::size_t b = 0; b < entries_.size(); ++b)
        if (levels_[b] + 1 < kLevelCount)
            bricks.push_back(b);
    serve(bricks, cache, ram, work);
}

void Atlas::serve(std::span<const std::size_t> bricks, BrickCache& cache, Ledger& ram, Work& work) {
    std::vector<std::uint8_t> keep(entries_.size(), 0);
    std::vector<std::size_t> missing;
    for (const std::size_t b : bricks) {
        keep[b] = 1;
        if (!isResident(b))
            missing.push_back(b);
    }
    // Others go only when their room is needed, then all at once, because a page holds bricks of one level.
    // Where pages of which little is kept still stand in the way, everything is packed anew.
    const auto evictUnless = [&](bool kept) {
        for (std::size_t b = 0; b < entries_.size(); ++b)
            if (isResident(b) && !(kept && keep[b]))
                evict(b);
        missing.clear();
        for (const std::size_t b : bricks)
            if (!isResident(b))
                missing.push_back(b);
    };
    if (!loadBricks(missing, cache, ram, work)) {
        evictUnless(true);
        if (!loadBricks(missing, cache, ram, work)) {
            evictUnless(false);
            TESSERA_CHECK(loadBricks(missing, cache, ram, work));
        }
    }
    writeIndex();
}

bool Atlas::loadBricks(std::vector<std::size_t> bricks, BrickCache& cache, Ledger& ram, Work& work) {
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
    const Charge charge = ram.charge(32768 * texelBytes(info_.type), "upload staging");
    std::vector<std::byte> staging(32768 * texelBytes(info_.type));
    std::size_t next = 0;
    bool room = true;
    forEachChunk(cache, keys, [&](const ChunkKey& chunkKey, const Chunk& chunk) {
        checkInterrupted();
        for (; room && next < bricks.size() && key(bricks[next]) == chunkKey; ++next)
            room = uploadBrick(bricks[next], chunk, staging.data(), work);
        return room;
    });
    glFinish();
    return room;
}

std::size_t Atlas::place(std::span<const BrickToPlace> bricks, Ledger& ram, Work& work) {
    const Charge charge = ram.charge(32768 * texelBytes(info_.type), "upload staging");
    std::vector<std::byte> staging(32768 * texelBytes(info_.type));
    std::size_t placed = 0;
    for (; placed < bricks.size(); ++placed) {
        const BrickToPlace& b = bricks[placed];
        TESSERA_CHECK(b.level + 1 < kLevelCount && b.chunk);
        const glm::uvec2 entry = entries_[b.brick];
        const std::uint8_t level = levels_[b.brick];
        const bool resident = isResident(b.brick);
        levels_[b.brick] = static_cast<std::uint8_t>(b.level);
        if (!uploadBrick(b.brick, *b.chunk, staging.data(), work)) {
            levels_[b.brick] = level;
            break;
        }
        if (resident)
            allocator_.release(slotOf(entry, level));
    }
    glFinish();
    return placed;
}

void Atlas::dropToMean(std::size_t brick, float mean) {
    if (isResident(brick))
        evict(brick);
    levels_[brick] = kLevelCount - 1;
    entries_[brick] = {kEntryValue, std::bit_cast<std::uint32_t>(mean)};
}

std::vector<std::size_t> Atlas::bricksOfSparsestPage() const {
    const glm::ivec3 pages = voxels_.extent() / kBrickExtent;
    std::vector<std::uint16_t> used(cellCount(pages));
    std::vector<std::uint8_t> level(used.size());
    const auto pageOf = [&](std::size_t b) {
        return linearIndex(slotOf(entries_[b], levels_[b]).page, pages);
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

bool Atlas::uploadBrick(std::size_t brick, const Chunk& chunk, std::byte* staging, Work& work) {
    const int level = levels_[brick], edge = kBrickExtent >> level;
    const auto slot = allocator_.allocate(level);
    if (!slot)
        return false;
    const glm::ivec3 inChunk = (gridPosition(brick, bricks_) & ((1 << level) - 1)) * edge;
    const std::size_t stored = bytesPerValue(info_.type), rowTexels = static_cast<std::size_t>(edge),
                      texel = texelBytes(info_.type);
    std::byte* row = staging;
    for (int z = 0; z < edge; ++z)
        for (int y = 0; y < edge; ++y) {
            const std::size_t at = linearIndex(inChunk + glm::ivec3(0, y, z), glm::ivec3(kChunkExtent));
            toTexels(info_.type, chunk.bytes.get() + at * stored, rowTexels, row);
            row += rowTexels * texel;
        }
    voxels_.upload(slot->originTexels(), glm::ivec3(edge), format_.external, format_.type, staging);
    const glm::uvec3 page(slot->page), place(slot->slot);
    entries_[brick] = {page.x | page.y << 10 | page.z << 20, place.x | place.y << 5 | place.z << 10};
    ++work.bricksUploaded;
    work.bytesUploaded += rowTexels * rowTexels * rowTexels * texel;
    return true;
}

void Atlas::bind(GLuint voxelUnit, GLuint indexUnit) const {
    voxels_.bind(voxelUnit);
    index_.bind(indexUnit);
}

GlTexture3d wholeLevelTexture(const VolumeInfo& info, int level, BrickCache& cache, Ledger& gpu,
                              Ledger& ram) {
    const TexelFormat format = texelFormat(info.type);
    const glm::ivec3 extent = levelExtent(info.extentVoxels, level);
    GlTexture3d texture(format.internal, extent, texelBytes(info.type), GL_LINEAR, gpu,
                        "the whole-level texture");
    const Charge charge = ram.charge(32768 * texelBytes(info.type), "upload staging");
    std::vector<std::byte> staging(32768 * texelBytes(info.type));
    std::vector<ChunkKey> keys;
    const glm::ivec3 chunks = chunkGrid(info.extentVoxels, level);
    for (int z = 0; z < chunks.z; ++z)
        for (int y = 0; y < chunks.y; ++y)
            for (int x = 0; x < chunks.x; ++x)
                keys.push_back({level, x, y, z});
    forEachChunk(cache, keys, [&](const ChunkKey& key, const Chunk& chunk) {
        const glm::ivec3 offset = glm::ivec3(key.i, key.j, key.k) * kChunkExtent;
        const glm::ivec3 size = glm::min(glm::ivec3(kChunkExtent), extent - offset);
        const std::size_t row = static_cast<std::size_t>(size.x), stored = bytesPerValue(info.type);
        std::byte* to = staging.data();
        for (int z = 0; z < size.z; ++z)
            for (int y = 0; y < size.y; ++y) {
                toTexels(info.type,
                         chunk.bytes.get() + linearIndex({0, y, z}, glm::ivec3(kChunkExtent)) * stored, row,
                         to);
                to += row * texelBytes(info.type);
            }
        texture.upload(offset, size, format.external, format.type, staging.data());
        return true;
    });
    return texture;
}

} // namespace tessera
