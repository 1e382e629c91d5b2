// bricking/analysis/lumen/lumen_search.h: least-cost paths through a lumen's graph: Dijkstra's search with
// parents, and costs that keep paths central.
#pragma once

#include "bricking/analysis/lumen/lumen_graph.h"

#include <functional>
#include <span>
#include <vector>

namespace tessera {

/// Result of a search: for every node the least cost from a source, infinite if not reached, and the node
/// before it.
struct LumenReach {
    Charge charge;
    std::vector<float> cost;
    std::vector<LumenNode> before;

    bool reached(LumenNode node) const { return cost[node] < std::numeric_limits<float>::infinity(); }
    /// From a source to the node.
    std::vector<LumenNode> pathTo(LumenNode node) const;
    /// The reached node of highest cost; kNoNode: none.
    LumenNode farthest() const;
};

/// @param perMm  the cost of a millimetre at each node, 0 or more; empty: 1
/// @param arrived  ends the search at the first node for which it is true; may be empty. Larger costs are
/// then
///     not minimal.
/// Throws InputError naming the budget's option, Cancelled and Interrupted.
LumenReach searchLumen(const LumenGraph& graph, std::span<const LumenNode> sources,
                       std::span<const float> perMm, MemoryBudget& ram,
                       const std::function<bool(LumenNode)>& arrived = {});

/// Shortens a path to the furthest point, which ends in a corner at the wall: removes its last steps, after
/// the node that was furthest from the wall.
void leaveCorner(const LumenGraph& graph, std::vector<LumenNode>& path);

/// (1 - D/Dmax)^4 plus a small share of the distance from the root; D is the distance to the wall. The first
/// term keeps a path central (TEASAR, Sato et al. 2000, in kimimaro's form), the second prevents detours in
/// wide lumens.
/// @param fromRoot  lengths from the root, mm; infinite if not connected
/// @param widestMm  Dmax; larger distances count as Dmax
std::vector<float> costsPerMm(const LumenGraph& graph, std::span<const float> fromRoot, float widestMm);

/// The largest distance to the wall of nodes within `reach` of a voxel, mm.
float widestNear(const LumenGraph& graph, const glm::ivec3& voxel, double reachMm);

} // namespace tessera
