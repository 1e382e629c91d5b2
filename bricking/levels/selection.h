// bricking/levels/selection.h: Selection: the level of every brick. A brick that is invisible under the
// transfer function is empty and costs nothing. All others have a level of their own (flat multiresolution,
// course notes 2.9.3).
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
    static constexpr std::uint8_t kEmpty = kLevelCount; // invisible: drawn as its mean
    glm::ivec3 bricks{0};                               // brickGrid(extent)
    std::vector<std::uint8_t> levels;                   // [z][y][x]: 0 (finest) to kLevelCount-1, or kEmpty
    std::vector<float> means; // [z][y][x], stored units: the value of empty bricks and of the coarsest level
    std::array<std::size_t, kLevelCount + 1> counts{}; // bricks per level; the last: empty ones

    std::size_t shownBricks() const { return levels.size() - counts[kEmpty]; }
    /// Of the visible bricks; kLevelCount-1 if there are none.
    int finest() const;
    int coarsest() const;
    /// Exactly one level in use, or none.
    bool uniform() const { return finest() == coarsest() || shownBricks() == 0; }
};

/// Bytes of packed bricks, from the number of bricks per level.
using PackedBytes = std::function<std::size_t(const std::array<std::size_t, kLevelCount + 1>& counts)>;

/// Finds empty bricks: those where the table's extinction is 0 over their voxels and the layers around them.
/// With one layer, values beside an empty brick are exact. Lit pictures need two, because gradients reach a
/// voxel further; smooth normals need the cells around. (At coarser levels both are blended with its mean.)
enum class Culling { none, unlit, lit, smooth }; // none: equality tests

/// Every brick is empty, or else of the given level.
Selection cullBricks(const Statistics& statistics, const TransferTable& table, const VolumeInfo& info,
                     int level, Culling culling);

/// One level for all visible bricks: the finest that fits.
/// @param availableBytes  free in the budget, for bricks and for the scene's fixedBytes
/// @param budgetName  the option that sets the budget
/// @param finest  no level finer than this
/// Throws InputError naming the minimum if even the coarsest level does not fit.
Selection selectOneLevel(const Statistics& statistics, const TransferTable& table, const VolumeInfo& info,
                         std::size_t availableBytes, const PackedBytes& packedBytes, Culling culling,
                         const std::string& budgetName, std::size_t fixedBytes, int finest = 0);

} // namespace tessera
