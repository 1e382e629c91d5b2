// bricking/analysis/lumen/lumen_search.h: least-cost paths through a lumen's graph: Dijkstra's search, whose
// parents are kept, with costs that keep to the middle.
#pragma once

#include "bricking/analysis/lumen/lumen_graph.h"

#include <functional>
#include <span>
#include <vector>

namespace tessera {

/// What a search found: for every node the least cost from a source, infinite where it did not come, and the
/// node before it.
struct LumenReach {
    Charge charge;
    std::vector<float> cost;
    std::vector<LumenNode> before;

    bool reached(LumenNode node) const { return cost[node] < std::numeric_limits<float>::infinity(); }
    /// From a source to the node.
    std::vector<LumenNode> pathTo(LumenNode node) const;
    /// Of those reached the one of the highest cost; kNoNode: none.
    LumenNode farthest() const;
};

/// @param perMm  the cost of a millimetre at each node, 0 or more; empty: 1
/// @param arrived  ends the search at the first node for which it holds; may be empty. Costs above that
///     node's are then not the least ones.
/// Throws InputError naming the budget's option, Cancelled and Interrupted.
LumenReach searchLumen(const LumenGraph& graph, std::span<const LumenNode> sources,
                       std::span<const float> perMm, MemoryBudget& ram,
                       const std::function<bool(LumenNode)>& arrived = {});

/// A path to the furthest place ends in a corner at the wall: the same without its last steps towards it,
/// from where it was furthest from the wall before.
void leaveCorner(const LumenGraph& graph, std::vector<LumenNode>& path);

/// (1 - D/Dmax)^4 plus a small share of the distance from the root: what keeps a path in the middle (TEASAR,
/// Sato et al. 2000, as kimimaro has it), and keeps it from wandering where the middle is wide. D is the
/// distance to the wall.
/// @param fromRoot  lengths from the root, mm; infinite where there is no way
/// @param widestMm  Dmax; what is wider counts as that
std::vector<float> costsPerMm(const LumenGraph& graph, std::span<const float> fromRoot, float widestMm);

/// Of the nodes within `reach` of a voxel the largest distance to the wall, mm.
float widestNear(const LumenGraph& graph, const glm::ivec3& voxel, double reachMm);

} // namespace tessera
