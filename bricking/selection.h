// bricking/selection.h: the pure function (statistics, transfer function, budget) -> level or nothing, per
// brick. Today all bricks that show share one level, the finest whose pages fit; bricks that show nothing
// cost nothing.
#pragma once

#include "bricking/statistics.h"
#include "core/brick.h"
#include "core/transfer_function.h"
#include "core/volume.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace tessera {

enum class BrickState : std::uint8_t { empty, resident };

struct Selection {
    int level = 0;                  // of every resident brick
    glm::ivec3 bricks{0};           // brickGrid(extent)
    std::vector<BrickState> states; // [z][y][x]
    std::vector<float> means;       // [z][y][x], stored units: what an empty brick reads as
    std::size_t residentCount = 0;
};

/// Bytes that `bricks` bricks of a level cost as they are really packed.
using PackedBytes = std::function<std::size_t(std::size_t bricks, int level)>;

/// @param cull  false: every brick is resident (equality tests)
/// @param availableBytes  free in the budget, for bricks and for the fixedBytes that the scene takes besides
/// @param budgetName  the option that sets the budget
/// Throws InputError naming the floor when even the coarsest level does not fit.
Selection selectOneLevel(const Statistics& statistics, const TransferTable& table, const VolumeInfo& info,
                         std::size_t availableBytes, const PackedBytes& packedBytes, bool cull,
                         const std::string& budgetName, std::size_t fixedBytes);

} // namespace tessera
