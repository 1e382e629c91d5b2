// bricking/analysis/surface/label_shares.cpp: see label_shares.h.
#include "bricking/analysis/surface/label_shares.h"

#include "core/base/threads.h"

#include <algorithm>
#include <cstring>
#include <glm/common.hpp>

namespace tessera {
namespace {

std::size_t readers(int threads) {
    return static_cast<std::size_t>(threads > 0 ? threads : defaultThreads());
}

} // namespace

LabelShares::LabelShares(const LabelVolume& labels, const std::vector<bool>& chosen, MemoryBudget& ram,
                         int threads)
    : labels_(labels), info_(labels.voxels().info()), cells_(labels.cells().cells),
      charge_(
          ram.charge(cellCount(cells_) * 2 * sizeof(float) + readers(threads) * labels.voxels().chunkBytes(),
                     "shares of labels")) {
    info_.type = ValueType::f32;
    info_.rescaleSlope = 1, info_.rescaleIntercept = 0;
    info_.fillStored = 0;
    for (const auto& set : labels.table().sets)
        bySet_.push_back(std::ranges::any_of(set, [&](std::uint16_t label) { return chosen[label]; }));
    low_.reserve(cellCount(cells_)), high_.reserve(cellCount(cells_));
    for (std::size_t cell = 0; cell < cellCount(cells_); ++cell) {
        const glm::ivec3 low = gridPosition(cell, cells_) * kCellExtent,
                         high = glm::min(low + kCellExtent, info_.extentVoxels);
        std::size_t voxels = 0;
        for (const LabelCells::Share& share : labels.cells().of(cell))
            voxels += bySet_[share.set] ? share.voxels : 0u;
        low_.push_back(voxels == cellCount(high - low) ? 1.f : 0.f);
        high_.push_back(voxels > 0 ? 1.f : 0.f);
    }
}

bool LabelShares::any() const {
    return std::ranges::any_of(high_, [](float share) { return share > 0; });
}

void LabelShares::readChunk(const ChunkKey& key, std::span<std::byte> out) const {
    const StoreReader& voxels = labels_.voxels();
    const bool wide = voxels.info().type == ValueType::u16;
    std::vector<std::byte> sets(voxels.chunkBytes());
    const auto isChosen = [&](std::size_t at) -> std::uint32_t {
        std::uint16_t set = static_cast<std::uint8_t>(sets[at]);
        if (wide)
            std::memcpy(&set, sets.data() + 2 * at, sizeof set);
        return bySet_[std::min<std::size_t>(set, bySet_.size() - 1)]; // of a damaged store, the last one
    };
    const glm::ivec3 first = kChunkExtent * glm::ivec3(key.i, key.j, key.k), grid(kChunkExtent);
    std::memset(out.data(), 0, out.size());
    const auto change = [&](std::size_t at, const auto& to) {
        float share;
        std::memcpy(&share, out.data() + sizeof share * at, sizeof share);
        share = to(share);
        std::memcpy(out.data() + sizeof share * at, &share, sizeof share);
    };
    const int pitch = 1 << key.level;
    const glm::ivec3 chunks = chunkGrid(info_.extentVoxels, 0);
    const glm::ivec3 from = glm::ivec3(key.i, key.j, key.k) * pitch, to = glm::min(from + pitch, chunks);
    for (int k = from.z; k < to.z; ++k)
        for (int j = from.y; j < to.y; ++j)
            for (int i = from.x; i < to.x; ++i) {
                voxels.readChunk({0, i, j, k}, sets);
                const glm::ivec3 corner = kChunkExtent * glm::ivec3(i, j, k),
                                 count = glm::min(grid, info_.extentVoxels - corner);
                for (int z = 0; z < count.z; ++z)
                    for (int y = 0; y < count.y; ++y)
                        for (int x = 0; x < count.x; ++x)
                            if (isChosen(linearIndex({x, y, z}, grid))) {
                                const glm::ivec3 sample = (corner + glm::ivec3(x, y, z)) / pitch;
                                change(linearIndex(sample - first, grid),
                                       [](float count) { return count + 1; });
                            }
            }
    for (std::size_t at = 0; pitch > 1 && at < cellCount(grid); ++at) {
        const glm::ivec3 low = pitch * (first + gridPosition(at, grid)), // of a sample at the end, fewer
            held = glm::clamp(info_.extentVoxels - low, glm::ivec3(0), glm::ivec3(pitch));
        if (const std::size_t voxels = cellCount(held); voxels > 0)
            change(at, [voxels](float count) { return count / static_cast<float>(voxels); });
    }
}

} // namespace tessera
