// bricking/analysis/lumen/lumen_parts.h: the connected parts of a lumen, one per seed, each grown on demand,
// and paths within a part.
#pragma once

#include "bricking/analysis/lumen/grow_lumen.h"
#include "bricking/analysis/lumen/lumen_graph.h"
#include "bricking/analysis/lumen/lumen_search.h"
#include "bricking/analysis/lumen/lumen_shape.h"
#include "core/base/progress.h"

#include <deque>
#include <optional>

namespace tessera {

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
