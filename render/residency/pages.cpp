// render/residency/pages.cpp: see pages.h.
#include "render/residency/pages.h"

#include "core/base/error.h"
#include "render/residency/texels.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace tessera {

PageAllocator::PageAllocator(const glm::ivec3& pages)
    : pages_(pages), page_(cellCount(pages)), partlyUsed_(kLevelCount) {
    for (std::size_t i = page_.size(); i > 0; --i)
        freePages_.push_back(i - 1); // page 0 is taken first
}

std::optional<AtlasSlot> PageAllocator::allocate(int level) {
    auto& candidates = partlyUsed_[static_cast<std::size_t>(level)];
    if (candidates.empty()) {
        if (freePages_.empty())
            return std::nullopt;
        const std::size_t fresh = freePages_.back();
        freePages_.pop_back();
        Page& page = page_[fresh];
        page.level = level;
        page.used = 0;
        page.freeSlots.clear();
        for (std::size_t i = slotsPerPage(level); i > 0; --i)
            page.freeSlots.push_back(static_cast<std::uint16_t>(i - 1));
        candidates.push_back(fresh);
    }
    const std::size_t index = candidates.back();
    Page& page = page_[index];
    const int slot = page.freeSlots.back();
    page.freeSlots.pop_back();
    ++page.used;
    if (page.freeSlots.empty())
        candidates.pop_back();
    const int edge = slotsPerEdge(level), at = static_cast<int>(index);
    return AtlasSlot{{at % pages_.x, at / pages_.x % pages_.y, at / (pages_.x * pages_.y)},
                     {slot % edge, slot / edge % edge, slot / (edge * edge)},
                     level};
}

void PageAllocator::release(const AtlasSlot& slot) {
    const std::size_t index = linearIndex(slot.page, pages_);
    Page& page = page_[index];
    TESSERA_CHECK(page.level == slot.level && page.used > 0);
    auto& candidates = partlyUsed_[static_cast<std::size_t>(slot.level)];
    if (page.freeSlots.empty())
        candidates.push_back(index);
    const int edge = slotsPerEdge(slot.level);
    page.freeSlots.push_back(static_cast<std::uint16_t>(linearIndex(slot.slot, glm::ivec3(edge))));
    if (--page.used > 0)
        return;
    candidates.erase(std::find(candidates.begin(), candidates.end(), index));
    page.level = -1;
    page.freeSlots.clear();
    page.freeSlots.shrink_to_fit();
    freePages_.push_back(index);
}

std::size_t pagesFor(const std::array<std::size_t, kLevelCount + 1>& counts) {
    std::size_t pages = 0;
    for (int level = 0; level + 1 < kLevelCount; ++level)
        pages += PageAllocator::pagesFor(counts[static_cast<std::size_t>(level)], level);
    return pages;
}

namespace {
std::size_t pageBytesOf(ValueType type, const TextureLimits& limits) {
    const std::size_t light = sizeof(std::uint16_t) * static_cast<std::size_t>(limits.channelsBeside);
    return cellCount(glm::ivec3(limits.pageEdge)) * (texelBytes(type) + light);
}
} // namespace

glm::ivec3 atlasPages(std::size_t pages, ValueType type, const TextureLimits& limits) {
    const std::size_t wanted = std::max<std::size_t>(1, pages);
    const std::size_t pageBytes = pageBytesOf(type, limits);
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
    return box.x == 0 ? std::numeric_limits<std::size_t>::max() : cellCount(box) * pageBytesOf(type, limits);
}

std::size_t pagesThatFit(std::size_t bytes, ValueType type, const TextureLimits& limits) {
    std::size_t pages = std::min(bytes, limits.maxBytes) / pageBytesOf(type, limits);
    while (pages > 0 && atlasBytes(pages, type, limits) > bytes)
        --pages;
    return pages;
}

std::size_t stagingBytes(const VolumeInfo& info) {
    return cellCount(glm::ivec3(kBrickExtent)) * texelBytes(info.type) +
           2 * indexBytes(brickGrid(info.extentVoxels)) + cellCount(brickGrid(info.extentVoxels));
}

ChunkKey chunkOf(std::size_t brick, int level, const glm::ivec3& bricks) {
    const glm::ivec3 chunk = gridPosition(brick, bricks) >> level;
    return {level, chunk.x, chunk.y, chunk.z};
}

} // namespace tessera
