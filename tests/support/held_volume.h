// tests/support/held_volume.h: a volume of floats in memory with its coarser levels, as chunks, and the
// ranges of its cells.
#pragma once

#include "bricking/analysis/surface/surface_mesh.h"
#include "bricking/cache/chunk_source.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <functional>
#include <glm/common.hpp>
#include <limits>
#include <vector>

namespace tessera::test {

class HeldVolume final : public ChunkSource {
  public:
    /// @param value  of a voxel
    HeldVolume(const glm::ivec3& extent, const std::function<double(const glm::ivec3&)>& value,
               const glm::dmat4& patientFromVoxel = glm::dmat4(1)) {
        info_.extentVoxels = extent;
        info_.type = ValueType::f32;
        info_.patientFromVoxel = patientFromVoxel;
        levels_.resize(kLevelCount);
        for (std::size_t at = 0; at < cellCount(extent); ++at)
            levels_[0].push_back(static_cast<float>(value(gridPosition(at, extent))));
        for (int level = 1; level < kLevelCount; ++level)
            levels_[static_cast<std::size_t>(level)] = coarser(level);
        const glm::ivec3 cells = cellGrid(extent);
        for (std::size_t cell = 0; cell < cellCount(cells); ++cell) {
            const glm::ivec3 low = glm::max(kCellExtent * gridPosition(cell, cells) - 1, glm::ivec3(0)),
                             high = glm::min(kCellExtent * (gridPosition(cell, cells) + 1), extent - 1);
            float lowest = std::numeric_limits<float>::infinity(), highest = -lowest;
            for (int z = low.z; z <= high.z; ++z)
                for (int y = low.y; y <= high.y; ++y)
                    for (int x = low.x; x <= high.x; ++x) {
                        lowest = std::min(lowest, at({x, y, z})), highest = std::max(highest, at({x, y, z}));
                    }
            low_.push_back(lowest), high_.push_back(highest);
        }
    }
    VolumeInfo& description() { return info_; }
    const VolumeInfo& info() const override { return info_; }
    float at(const glm::ivec3& voxel, int level = 0) const {
        return levels_[static_cast<std::size_t>(level)]
                      [linearIndex(voxel, levelExtent(info_.extentVoxels, level))];
    }
    CellRanges ranges() const { return {cellGrid(info_.extentVoxels), low_, high_, 1}; }
    /// Ranges that leave nothing out.
    CellRanges wideRanges() const {
        wideLow_.assign(low_.size(), -1e30f), wideHigh_.assign(high_.size(), 1e30f);
        return {cellGrid(info_.extentVoxels), wideLow_, wideHigh_, 1};
    }
    void readChunk(const ChunkKey& key, std::span<std::byte> out) const override {
        ++chunksRead;
        const glm::ivec3 extent = levelExtent(info_.extentVoxels, key.level);
        for (std::size_t n = 0; n < out.size() / 4; ++n) {
            const glm::ivec3 voxel =
                kChunkExtent * glm::ivec3(key.i, key.j, key.k) + gridPosition(n, glm::ivec3(kChunkExtent));
            // beyond the edge something that would be seen
            const float value =
                voxel.x < extent.x && voxel.y < extent.y && voxel.z < extent.z ? at(voxel, key.level) : 1e20f;
            std::memcpy(out.data() + 4 * n, &value, 4);
        }
    }
    mutable std::atomic<std::uint64_t> chunksRead = 0;

  private:
    std::vector<float> coarser(int level) const {
        const glm::ivec3 fine = levelExtent(info_.extentVoxels, level - 1),
                         extent = levelExtent(info_.extentVoxels, level);
        std::vector<float> values;
        for (std::size_t n = 0; n < cellCount(extent); ++n) {
            const glm::ivec3 low = 2 * gridPosition(n, extent), high = glm::min(low + 1, fine - 1);
            double sum = 0;
            int count = 0;
            for (int z = low.z; z <= high.z; ++z)
                for (int y = low.y; y <= high.y; ++y)
                    for (int x = low.x; x <= high.x; ++x, ++count)
                        sum += static_cast<double>(at({x, y, z}, level - 1));
            values.push_back(static_cast<float>(sum / count));
        }
        return values;
    }

    VolumeInfo info_;
    std::vector<std::vector<float>> levels_;
    std::vector<float> low_, high_;
    mutable std::vector<float> wideLow_, wideHigh_;
};

} // namespace tessera::test
