// render/atlas.cpp: see atlas.h.
#include "render/atlas.h"

#include "core/error.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <vector>

namespace tessera {
namespace {

constexpr std::uint32_t kEntryValue = 0x80000000u; // sampler_atlas.glsl has the same

template <typename Stored, typename Texel, typename Convert>
void convert(const std::byte* stored, std::size_t count, std::byte* texels, Convert convertOne) {
    for (std::size_t i = 0; i < count; ++i) {
        Stored value;
        std::memcpy(&value, stored + i * sizeof(Stored), sizeof(Stored));
        const Texel texel = convertOne(value);
        std::memcpy(texels + i * sizeof(Texel), &texel, sizeof(Texel));
    }
}

/// Chunks in batches the cache can pin at once while others are decoded.
template <typename Visit>
void forEachChunk(BrickCache& cache, const std::vector<ChunkKey>& keys, const Visit& visit) {
    const std::size_t batch = std::max<std::size_t>(1, cache.pinnableChunks() / 2);
    for (std::size_t first = 0; first < keys.size(); first += batch) {
        const std::size_t count = std::min(batch, keys.size() - first);
        auto futures = cache.request(std::span(keys).subspan(first, count));
        for (std::size_t i = 0; i < count; ++i) {
            visit(keys[first + i], *futures[i].get());
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

Atlas::Atlas(const VolumeInfo& info, const Selection& selection, const TextureLimits& limits, Ledger& gpu)
    : info_(info), selection_(selection), format_(texelFormat(info.type)),
      allocator_(atlasPages(pagesFor(selection.counts), info.type, limits)) {
    const glm::ivec3 pages = atlasPages(pagesFor(selection.counts), info.type, limits);
    TESSERA_CHECK(pages.x > 0);
    voxels_ = GlTexture3d(format_.internal, pages * kBrickExtent, texelBytes(info.type), GL_LINEAR, gpu,
                          "the brick atlas");
    index_ = GlTexture3d(GL_RG32UI, selection.bricks, 8, GL_NEAREST, gpu, "the brick index");
}

std::size_t Atlas::stagingBytes(const VolumeInfo& info) {
    return cellCount(glm::ivec3(kBrickExtent)) * texelBytes(info.type) +
           2 * indexBytes(brickGrid(info.extentVoxels));
}

void Atlas::load(BrickCache& cache, Ledger& ram, Work& work) {
    const std::size_t chunkTexels = 32768;
    const Charge charge = ram.charge(stagingBytes(info_), "upload staging");
    std::vector<std::byte> staging(chunkTexels * texelBytes(info_.type));
    entries_.assign(cellCount(selection_.bricks), glm::uvec2(0));
    for (std::size_t b = 0; b < entries_.size(); ++b)
        if (selection_.levels[b] + 1 >= kLevelCount)
            entries_[b] = {kEntryValue, std::bit_cast<std::uint32_t>(selection_.means[b])};
    forEachChunk(cache, chunksToLoad(), [&](const ChunkKey& key, const Chunk& chunk) {
        uploadChunk(key, chunk, staging.data(), work);
    });
    index_.upload(glm::ivec3(0), selection_.bricks, GL_RG_INTEGER, GL_UNSIGNED_INT, entries_.data());
    glFinish(); // the driver may still hold copies of what was handed over
    entries_ = {};
}

namespace {
/// Bricks that a chunk holds: [first, end) of the brick grid. A chunk of level l holds 2^l bricks per edge.
struct BrickBox {
    glm::ivec3 first, end;
};
BrickBox bricksOf(const ChunkKey& key, const glm::ivec3& bricks) {
    const glm::ivec3 first = glm::ivec3(key.i, key.j, key.k) << key.level;
    return {first, glm::min(first + (1 << key.level), bricks)};
}
template <typename Visit> void forEachBrick(const BrickBox& box, const Visit& visit) {
    glm::ivec3 at(0);
    for (at.z = box.first.z; at.z < box.end.z; ++at.z)
        for (at.y = box.first.y; at.y < box.end.y; ++at.y)
            for (at.x = box.first.x; at.x < box.end.x; ++at.x)
                visit(at);
}
} // namespace

std::vector<ChunkKey> Atlas::chunksToLoad() const {
    std::vector<ChunkKey> keys;
    for (int level = kLevelCount - 2; level >= 0; --level) { // coarse ones first: they are few
        if (selection_.counts[static_cast<std::size_t>(level)] == 0)
            continue;
        const glm::ivec3 chunks = chunkGrid(info_.extentVoxels, level);
        forEachBrick({glm::ivec3(0), chunks}, [&](const glm::ivec3& at) {
            const ChunkKey key{level, at.x, at.y, at.z};
            bool any = false;
            forEachBrick(bricksOf(key, selection_.bricks), [&](const glm::ivec3& brick) {
                any = any || selection_.levels[linearIndex(brick, selection_.bricks)] == level;
            });
            if (any)
                keys.push_back(key);
        });
    }
    return keys;
}

void Atlas::uploadChunk(const ChunkKey& key, const Chunk& chunk, std::byte* staging, Work& work) {
    const int edge = kBrickExtent >> key.level;
    const std::size_t stored = bytesPerValue(info_.type);
    const std::size_t rowTexels = static_cast<std::size_t>(edge), texel = texelBytes(info_.type);
    const BrickBox box = bricksOf(key, selection_.bricks);
    forEachBrick(box, [&](const glm::ivec3& brick) {
        const std::size_t number = linearIndex(brick, selection_.bricks);
        if (selection_.levels[number] != key.level)
            return;
        const glm::ivec3 corner = (brick - box.first) * edge; // inside the chunk
        std::byte* row = staging;
        for (int z = 0; z < edge; ++z)
            for (int y = 0; y < edge; ++y) {
                const std::size_t at = linearIndex(corner + glm::ivec3(0, y, z), glm::ivec3(kChunkExtent));
                toTexels(info_.type, chunk.bytes.get() + at * stored, rowTexels, row);
                row += rowTexels * texel;
            }
        const auto slot = allocator_.allocate(key.level);
        TESSERA_CHECK(slot.has_value());
        voxels_.upload(slot->originTexels(), glm::ivec3(edge), format_.external, format_.type, staging);
        const glm::uvec3 page(slot->page), place(slot->slot);
        entries_[number] = {page.x | page.y << 10 | page.z << 20, place.x | place.y << 5 | place.z << 10};
        ++work.bricksUploaded;
        work.bytesUploaded += rowTexels * rowTexels * rowTexels * texel;
    });
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
    });
    return texture;
}

} // namespace tessera
