// core/scene/reformed_sheet.cpp: see reformed_sheet.h.
#include "core/scene/reformed_sheet.h"

#include "core/base/error.h"
#include "core/scene/scene.h" // kMaxImageExtent

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>

namespace tessera {
namespace {

constexpr int kInOneRow = 6; // cross-sections alone; more lie in rows, about twice as wide as high

/// Throws InputError for a side of an image that is too long.
void checkExtent(std::size_t pixels) {
    if (pixels > static_cast<std::size_t>(Scene::kMaxImageExtent))
        throw badFile("pictures side by side",
                      "at most " + std::to_string(Scene::kMaxImageExtent) + " pixels along a side together",
                      std::to_string(pixels));
}

} // namespace

glm::ivec2 layOutPictures(std::vector<Reformation>& pictures) {
    std::size_t right = 0, along = 0; // pixels that are taken; pictures along the line
    int height = 0;
    for (; along < pictures.size() && !pictures[along].isSection; ++along) {
        pictures[along].from = {static_cast<int>(right), 0};
        right += static_cast<std::size_t>(pictures[along].columns + kReformedGap);
        height = std::max(height, pictures[along].size().y);
        checkExtent(right);
    }
    const std::size_t sections = pictures.size() - along;
    if (sections == 0)
        return sizeOf(pictures);
    const glm::ivec2 step = pictures[along].size() + kReformedGap;
    const auto inRow = static_cast<std::size_t>(
        sections <= kInOneRow ? static_cast<double>(sections)
                              : std::ceil(std::sqrt(2.0 * static_cast<double>(sections))));
    const auto inColumn = static_cast<std::size_t>(std::max(1, (height + kReformedGap) / step.y));
    for (std::size_t n = 0; n < sections; ++n) {
        const std::size_t column = along > 0 ? n / inColumn : n % inRow,
                          row = along > 0 ? n % inColumn : n / inRow;
        const std::size_t x = right + column * static_cast<std::size_t>(step.x),
                          y = row * static_cast<std::size_t>(step.y);
        checkExtent(x + static_cast<std::size_t>(step.x));
        checkExtent(y + static_cast<std::size_t>(step.y));
        pictures[along + n].from = {static_cast<int>(x), static_cast<int>(y)};
    }
    return sizeOf(pictures);
}

glm::ivec2 sizeOf(const std::vector<Reformation>& pictures) {
    glm::ivec2 size(0);
    for (const Reformation& picture : pictures) {
        size.x = std::max(size.x, picture.from.x + picture.size().x);
        size.y = std::max(size.y, picture.from.y + picture.size().y);
    }
    return size;
}

} // namespace tessera
