// bricking/statistics/gathered_ranges.cpp: see gathered_ranges.h.
#include "bricking/statistics/gathered_ranges.h"

#include "core/base/brick.h"

#include <algorithm>
#include <glm/common.hpp>
#include <limits>

namespace tessera {

void clearRanges(const RangeWindow& window) {
    std::fill(window.least.begin(), window.least.end(), std::numeric_limits<float>::infinity());
    std::fill(window.most.begin(), window.most.end(), -std::numeric_limits<float>::infinity());
}

GatheredRanges::GatheredRanges(const glm::ivec3& grid, int perBrick, MemoryBudget& ram)
    : grid_(grid), perBrick_(perBrick), charge_(ram.charge(bytes(grid), "statistics")),
      least_(cellCount(grid)), most_(cellCount(grid)), window_{glm::ivec3(0), grid, least_, most_} {
    clearRanges(window_);
}

GatheredRanges::GatheredRanges(const glm::ivec3& grid, int perBrick, const glm::ivec3& mostBricks,
                               const std::filesystem::path& folder, MemoryBudget& ram)
    : grid_(grid), perBrick_(perBrick),
      charge_(ram.charge(windowBytes(grid, perBrick, mostBricks), "statistics")),
      least_(windowBytes(grid, perBrick, mostBricks) / 2 / sizeof(float)), most_(least_.size()) {
    requireDiskRoom(folder, bytes(grid), "ranges of cells");
    file_.emplace(folder);
}

std::size_t GatheredRanges::bytes(const glm::ivec3& grid) {
    return 2 * sizeof(float) * cellCount(grid);
}

std::size_t GatheredRanges::windowBytes(const glm::ivec3& grid, int perBrick, const glm::ivec3& mostBricks) {
    const glm::ivec3 most = glm::min(mostBricks * perBrick + 2, grid);
    return bytes({grid.x, most.y, most.z});
}

std::uint64_t GatheredRanges::placeOf(Side side, int slice, int row) const {
    const std::size_t before = side == Side::least ? 0 : cellCount(grid_);
    return sizeof(float) * std::uint64_t{before + linearIndex({0, row, slice}, grid_)};
}

void GatheredRanges::begin(const glm::ivec3& firstBrick, const glm::ivec3& endBrick) {
    if (!file_)
        return;
    const glm::ivec3 before = window_.first + window_.extent; // of the last band
    if (firstBrick.z != group_) {
        keptSlices_ = group_ < 0 ? 0 : before.z;
        keptRows_ = 0;
        group_ = firstBrick.z;
    } else {
        keptRows_ = before.y;
    }
    const glm::ivec3 first = glm::max(firstBrick * perBrick_ - 1, glm::ivec3(0));
    const glm::ivec3 end = glm::min(endBrick * perBrick_ + 1, grid_);
    const std::size_t size = cellCount(end - first);
    window_ = {first, end - first, std::span(least_).first(size), std::span(most_).first(size)};
    clearRanges(window_);
    for (int z = first.z; z < end.z; ++z) {
        const int rows = z < keptSlices_ ? window_.extent.y : std::max(keptRows_ - first.y, 0);
        const std::size_t at = linearIndex({0, 0, z - first.z}, window_.extent),
                          count = cellCount({grid_.x, rows, 1});
        if (rows == 0)
            continue;
        file_->read(placeOf(Side::least, z, first.y),
                    std::as_writable_bytes(window_.least.subspan(at, count)));
        file_->read(placeOf(Side::most, z, first.y), std::as_writable_bytes(window_.most.subspan(at, count)));
    }
}

void GatheredRanges::end() {
    if (!file_)
        return;
    const std::size_t count = cellCount({window_.extent.x, window_.extent.y, 1});
    for (int z = 0; z < window_.extent.z; ++z) {
        const std::size_t at = static_cast<std::size_t>(z) * count;
        const int slice = window_.first.z + z;
        file_->write(placeOf(Side::least, slice, window_.first.y),
                     std::as_bytes(window_.least.subspan(at, count)));
        file_->write(placeOf(Side::most, slice, window_.first.y),
                     std::as_bytes(window_.most.subspan(at, count)));
    }
}

void GatheredRanges::read(Side side, int slice, int firstRow, std::span<float> rows) const {
    if (file_)
        return file_->read(placeOf(side, slice, firstRow), std::as_writable_bytes(rows));
    const std::vector<float>& values = side == Side::least ? least_ : most_;
    const auto from = values.begin() + static_cast<std::ptrdiff_t>(linearIndex({0, firstRow, slice}, grid_));
    std::copy_n(from, rows.size(), rows.begin());
}

} // namespace tessera
