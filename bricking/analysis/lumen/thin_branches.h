// bricking/analysis/lumen/thin_branches.h: thin branches that a guarded threshold leaves out of a tree. They
// begin, or have a narrow part, where the partial volume of both walls or noise closes them. A leak is
// blocked where it occurs.
#pragma once

#include "bricking/analysis/lumen/grow_lumen.h"
#include "bricking/analysis/lumen/seed_threshold.h"

#include <optional>

namespace tessera {

struct ThinBranches {
    std::uint64_t voxels = 0; ///< voxels added to the lumen
    std::size_t branches = 0; ///< added pieces
    std::size_t leaks = 0;    ///< blocked voxels
    std::optional<double> to; ///< value at which the last piece was reached, physical units; none: no piece
};

/// A flood goes on from the lumen, voxel by voxel in the order of their values (as Meyer's watershed), from
/// its threshold to another. Behind a voxel it fills the region of deeper values, lowest first. A piece is a
/// branch if it has at most 1000 mm3 and a wall: its border differs from it by more than noise. Otherwise the
/// voxel is blocked. Branches of 8 mm3 and more become lumen, with up to 6 mm of path to them.
/// @param lumen  grown with the rule
/// @param wall  least difference between a branch and its border, physical units
/// @param to  threshold at which the flood ends, physical units, no stricter than the rule's
/// Throws InputError naming the budget's option if visited voxels do not fit, Interrupted, and as reading
/// chunks does.
ThinBranches addThinBranches(LumenValues& values, GrownLumen& lumen, const LumenRule& rule, double wall,
                             double to, MemoryBudget& ram);
/// Least difference of a wall around thin branches: three times the remaining noise, and a quarter of the
/// distance from the lumen's value to the threshold.
double branchWall(const SeedNeighbourhood& around, const LumenRule& rule);

} // namespace tessera
