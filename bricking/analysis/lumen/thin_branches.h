// bricking/analysis/lumen/thin_branches.h: thin branches that a guarded threshold leaves out of a tree. They
// begin, or have a narrow part, where walls shine in from both sides or noise stands in the way. A leak is
// dammed where it is.
#pragma once

#include "bricking/analysis/lumen/grow_lumen.h"
#include "bricking/analysis/lumen/seed_threshold.h"

#include <optional>

namespace tessera {

struct ThinBranches {
    std::uint64_t voxels = 0; ///< that the lumen got
    std::size_t branches = 0; ///< pieces of it
    std::size_t leaks = 0;    ///< places that were dammed
    std::optional<double>
        to; ///< the value that the last piece was reached at, physical units; none: no piece
};

/// A flood goes on from the lumen, voxel by voxel in the order of their values (as Meyer's watershed), from
/// its threshold to another. Behind a voxel it fills what is deeper, lowest first. A piece that is full
/// before it runs over into more than 1000 mm3 is a branch where what borders it stands out of it, by more
/// than noise does: a wall. Else the voxel is a dam. Branches of 8 mm3 and more become lumen, with up to 6 mm
/// of way to them.
/// @param lumen  grown with the rule
/// @param wall  how far what borders a branch stands out of it, at least, physical units
/// @param to  threshold at which the flood ends, physical units, no stricter than the rule's
/// Throws InputError naming the budget's option where what it visits does not fit, Interrupted, and what
/// reading throws.
ThinBranches addThinBranches(LumenValues& values, GrownLumen& lumen, const LumenRule& rule, double wall,
                             double to, MemoryBudget& ram);
/// A wall around thin branches, as a place in the lumen has it: three times the noise that is left there, and
/// a quarter of the way from the lumen's value to the threshold.
double branchWall(const SeedNeighbourhood& around, const LumenRule& rule);

} // namespace tessera
