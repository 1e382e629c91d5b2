// bricking/analysis/lumen/lumen_tree.h: the branches of a lumen, each from where it leaves another to its
// end, and their centre-lines between the forks. In code a branch is a LumenLimb.
#pragma once

#include "bricking/analysis/lumen/centre_path.h"
#include "bricking/analysis/lumen/lumen_graph.h"
#include "bricking/analysis/lumen/lumen_paths.h"
#include "core/animation/path.h"

#include <functional>
#include <vector>

namespace tessera {

struct LumenLimb {
    std::vector<LumenNode> nodes; ///< from where it leaves its parent, or from the root, to its end
    int parent = -1;              ///< an earlier branch; -1: the root
};

/// As in TEASAR, the point furthest from the root that no branch is near becomes the end of the next branch.
/// This takes the least-cost path to the existing branches. Along those the cost is zero, so branches
/// separate late. A branch serves what lies within 1.5 wall distances and two voxels of it. A branch is a
/// spur, and left out, if its length beyond its parent's wall is at most its width or 3 mm.
std::vector<LumenLimb> lumenLimbs(const LumenGraph& graph, LumenNode root, MemoryBudget& ram,
                                  const std::function<void(double)>& shareDone = {});

struct LumenBranches {
    std::vector<CentreLine> lines; ///< lines between forks, each after its parent
    std::vector<int> generations;  ///< forks between the root and the line
    double leastTurnMm = 0;
};
/// The branches' centre-lines, split at forks.
/// @param generations  lines beyond this number of forks are left out
LumenBranches branchLines(const LumenGraph& graph, const std::vector<LumenLimb>& limbs,
                          const LumenShape& shape, LumenValues& values, const LumenRule& rule,
                          double spacingMm, int generations,
                          const std::function<void(double)>& shareDone = {});

} // namespace tessera
