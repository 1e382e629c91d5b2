// render/backends/native/fine_blocks.h: the blocks of 2^3 voxels of an occupied cell that can show anything,
// as bits of the distance map (render/empty_space/distance_map.h). They are found from the samples that the
// engine holds (block_ranges.h). A cell is examined when the first ray gets to it, so cells that no ray meets
// cost nothing.
#pragma once

#include "bricking/statistics/statistics.h"
#include "core/base/budget.h"
#include "core/scene/transfer_function.h"
#include "render/backends/native/host_plane.h"
#include "render/contract/optics.h"
#include "render/contract/ray.h"
#include "render/empty_space/occupancy.h"

#include <atomic>
#include <cstdint>
#include <vector>

namespace tessera {

/// The inputs of blocks. They outlive the blocks and stay as they are; all bricks are there.
struct FineBlocksInput {
    const HostPlane& plane;
    const Occupancy& occupancy; // by cells
    const Statistics& statistics;
    const LevelMap* levels; // of mixed levels, or null
    int level;              // else: of all bricks
    const TransferTable& table;
    const Optics& optics;
    const native::PacketTarget& target;
};

class FineBlocks {
  public:
    /// No cell is tested yet. Charges as many bytes as the map has.
    FineBlocks(const FineBlocksInput& input, MemoryBudget& gpu);
    FineBlocks(const FineBlocks&) = delete;
    FineBlocks& operator=(const FineBlocks&) = delete;

    static std::size_t bytes(const Occupancy& occupancy) {
        return occupancy.map().size() * sizeof(SkippingTexel);
    }
    /// True if a picture gains more than finding blocks costs.
    /// @param raysPerCell  of raysPerCell()
    static bool pay(bool mixed, double raysPerCell);

    /// The map that packets read in place of the occupancy's. Any number of threads.
    native::PacketEmptySpace space() const;
    /// Cells that were tested. Those of which every value shows are not: all their blocks do.
    std::size_t looked() const { return looked_.load(std::memory_order_relaxed); }

  private:
    void look(std::int32_t cell) const;

    FineBlocksInput in_;
    Charge charge_;
    mutable std::vector<SkippingTexel> map_; // 0: not tested. Written by any thread, each texel whole
    mutable std::atomic<std::size_t> looked_{0};
};

/// Rays of a picture that go through a cell of 8^3 voxels, in the plane that they are aimed at.
double raysPerCell(const RayFrame<double>& frame);

} // namespace tessera
