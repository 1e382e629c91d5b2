// bricking/analysis/lumen/lumen_paths.h: least-cost paths through a lumen's graph: Dijkstra's search with
// parents, and costs that keep paths central. The connected parts of a lumen, one per seed, each grown on
// demand, and paths within a part.
#pragma once

#include "bricking/analysis/lumen/grow_lumen.h"
#include "bricking/analysis/lumen/lumen_graph.h"
#include "bricking/analysis/lumen/lumen_shape.h"
#include "core/base/progress.h"

#include <deque>
#include <functional>
#include <optional>
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

/// Largest number of a graph's blocks: searching them twice takes some tenths of a second.
constexpr std::uint64_t kBlocksOfPath = 200000, kBlocksOfTree = 600000;

struct LumenPart {
    LumenPart(GrownLumen&& lumen, const VolumeInfo& info)
        : grown(std::move(lumen)), shape(grown.voxels, info) {}
    GrownLumen grown;
    LumenShape shape;
    std::optional<LumenGraph> graph; ///< made on demand
};

class LumenParts {
  public:
    LumenParts(BrickCache& cache, const VolumeInfo& info, const LumenRule& rule, MemoryBudget& ram,
               Progress& progress)
        : cache_(cache), info_(info), rule_(rule), ram_(ram), progress_(progress) {}

    /// The part of a voxel that passes the rule.
    LumenPart& partOf(const glm::ivec3& voxel);
    /// Adds a region that is grown already.
    LumenPart& add(GrownLumen&& grown) { return parts_.emplace_back(std::move(grown), info_); }
    /// @param mostBlocks  largest number of its blocks; from the first call
    const LumenGraph& graphOf(LumenPart& part, std::uint64_t mostBlocks = kBlocksOfPath);
    /// A chain of voxels in the middle of the part; without `to`, to the furthest point.
    std::vector<glm::ivec3> way(LumenPart& part, const glm::ivec3& from, const std::optional<glm::ivec3>& to);

    /// The union of the requested parts, for a line through several; no part may be requested afterwards.
    LumenPart& whole();

  private:
    BrickCache& cache_;
    const VolumeInfo& info_;
    const LumenRule rule_;
    MemoryBudget& ram_;
    Progress& progress_;
    std::deque<LumenPart> parts_;
};

} // namespace tessera
