// bricking/levels/selection.h: Selection: the level that every brick is drawn at. A brick that shows nothing
// under the transfer function is empty and costs nothing. All others have a level of their own (flat
// multiresolution, course notes 2.9.3).
#pragma once

#include "bricking/statistics/statistics.h"
#include "core/base/brick.h"
#include "core/base/volume.h"
#include "core/scene/transfer_function.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace tessera {

struct Selection {
    static constexpr std::uint8_t kEmpty = kLevelCount; // shows nothing: stands as its mean
    glm::ivec3 bricks{0};                               // brickGrid(extent)
    std::vector<std::uint8_t> levels;                   // [z][y][x]: 0 (finest) to kLevelCount-1, or kEmpty
    std::vector<float> means; // [z][y][x], stored units: what empty bricks and the coarsest level read as
    std::array<std::size_t, kLevelCount + 1> counts{}; // bricks per level; the last: empty ones

    std::size_t shownBricks() const { return levels.size() - counts[kEmpty]; }
    /// Of the bricks that show something; kLevelCount-1 where none does.
    int finest() const;
    int coarsest() const;
    /// Exactly one level in use, or none.
    bool uniform() const { return finest() == coarsest() || shownBricks() == 0; }
};

/// Bytes that bricks cost as they are really packed, from the number of bricks per level.
using PackedBytes = std::function<std::size_t(const std::array<std::size_t, kLevelCount + 1>& counts)>;

/// Which bricks are empty: those where the table's extinction is 0 over their voxels and the layers around
/// them. One layer suffices for values beside an empty brick to be as if it were there; lit pictures ask for
/// two, because gradients reach a voxel further. (At coarser levels both are blended with its mean.)
enum class Culling { none, unlit, lit }; // none: equality tests

/// Every brick by itself: empty, or else of the given level.
Selection cullBricks(const Statistics& statistics, const TransferTable& table, const VolumeInfo& info,
                     int level, Culling culling);

/// One level for all bricks that show something: the finest that fits.
/// @param availableBytes  free in the budget, for bricks and for the fixedBytes that the scene takes besides
/// @param budgetName  the option that sets the budget
/// @param finest  no level finer than this
/// Throws InputError naming the floor when even the coarsest level does not fit.
Selection selectOneLevel(const Statistics& statistics, const TransferTable& table, const VolumeInfo& info,
                         std::size_t availableBytes, const PackedBytes& packedBytes, Culling culling,
                         const std::string& budgetName, std::size_t fixedBytes, int finest = 0);

} // namespace tessera
