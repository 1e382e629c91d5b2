// render/residency/page_allocator.cpp: see page_allocator.h.
#include "render/residency/page_allocator.h"

#include "core/base/error.h"

#include <algorithm>

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

} // namespace tessera
