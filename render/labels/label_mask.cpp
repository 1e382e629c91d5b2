// render/labels/label_mask.cpp: see label_mask.h.
#include "render/labels/label_mask.h"

#include "core/base/error.h"

#include <algorithm>
#include <utility>

namespace tessera {

std::vector<LabelFactors> drawnOrHidden(std::vector<LabelFactors> bySet) {
    for (LabelFactors& factors : bySet)
        factors = {.plain = factors.shows() ? 1.0f : 0.0f};
    return bySet;
}

LabelMask::LabelMask(std::unique_ptr<DrawnLabels> labels) : labels_(std::move(labels)) {
    const LabelCells& cells = labels_->volume().cells();
    ofCell_.resize(cellCount(cells.cells));
    for (std::size_t cell = 0; cell < ofCell_.size(); ++cell) {
        bool shows = false, hides = false;
        for (const LabelCells::Share& share : cells.of(cell))
            (labels_->factors()[share.set].shows() ? shows : hides) = true;
        ofCell_[cell] = !hides ? Part::none : shows ? Part::some : Part::all;
    }
}

HiddenPart::Part LabelMask::of(const glm::ivec3& low, const glm::ivec3& high) const {
    const glm::ivec3& grid = labels_->volume().cells().cells;
    const glm::ivec3 first = glm::max(low, glm::ivec3(0)) / kCellExtent;
    const glm::ivec3 end = glm::min((high + (kCellExtent - 1)) / kCellExtent, grid);
    bool none = true, all = true;
    for (int z = first.z; z < end.z; ++z)
        for (int y = first.y; y < end.y; ++y)
            for (int x = first.x; x < end.x; ++x) {
                const Part part = ofCell_[linearIndex({x, y, z}, grid)];
                none = none && part == Part::none;
                all = all && part == Part::all;
            }
    return none ? Part::none : all ? Part::all : Part::some;
}

void LabelMask::read(int level, const glm::ivec3& first, const glm::ivec3& count,
                     std::span<float> out) const {
    TESSERA_CHECK(first % kChunkExtent == glm::ivec3(0) && out.size() >= cellCount(count));
    const glm::ivec3 chunk = first / kChunkExtent;
    constexpr glm::ivec3 kWhole(kChunkExtent);
    std::vector<float> shown(cellCount(kWhole), 1.0f), medium(shown.size());
    labels_->extinctions({level, chunk.x, chunk.y, chunk.z}, shown, medium);
    for (int z = 0; z < count.z; ++z)
        for (int y = 0; y < count.y; ++y)
            for (int x = 0; x < count.x; ++x)
                out[linearIndex({x, y, z}, count)] =
                    std::clamp(1 - shown[linearIndex({x, y, z}, kWhole)], 0.0f, 1.0f);
}

} // namespace tessera
