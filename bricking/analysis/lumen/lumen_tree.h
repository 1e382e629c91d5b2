// bricking/analysis/lumen/lumen_tree.h: the branches of a lumen, each from where it leaves another to its
// end, and their centre-lines between the forks. A branch is a LumenLimb in code.
#pragma once

#include "bricking/analysis/lumen/centre_path.h"
#include "bricking/analysis/lumen/lumen_graph.h"
#include "bricking/analysis/lumen/lumen_search.h"
#include "core/animation/path.h"

#include <functional>
#include <vector>

namespace tessera {

struct LumenLimb {
    std::vector<LumenNode> nodes; ///< from where it leaves its parent, or from the root, to its end
    int parent = -1;              ///< an earlier limb; -1: the root
};

/// As TEASAR: the furthest place from the root that no limb is near becomes the end of the next. It goes the
/// least-cost way to the limbs that are there. Along these it costs nothing, so limbs leave late. What lies
/// within 1.5 wall distances and two voxels of a limb is served by it. A limb is a spur, and left out, where
/// it is not longer beyond its parent's wall than it is wide, or than 3 mm.
std::vector<LumenLimb> lumenLimbs(const LumenGraph& graph, LumenNode root, MemoryBudget& ram,
                                  const std::function<void(double)>& shareDone = {});

struct LumenBranches {
    std::vector<CentreLine> lines; ///< between forks, each after its parent
    std::vector<int> generations;  ///< forks between the root and the line
    double leastTurnMm = 0;
};
/// The limbs' middles, parted where others leave them.
/// @param generations  lines beyond that many forks are left out
LumenBranches branchLines(const LumenGraph& graph, const std::vector<LumenLimb>& limbs,
                          const LumenShape& shape, LumenValues& values, const LumenRule& rule,
                          double spacingMm, int generations,
                          const std::function<void(double)>& shareDone = {});

} // namespace tessera
