// bricking/analysis/lumen/lumen_parts.cpp: see lumen_parts.h.
#include "bricking/analysis/lumen/lumen_parts.h"

#include <array>

namespace tessera {
LumenPart& LumenParts::partOf(const glm::ivec3& voxel) {
    for (LumenPart& part : parts_)
        if (part.grown.voxels.contains(voxel))
            return part;
    progress_.stage("growing the lumen");
    return add(growLumen(cache_, info_, rule_, voxel, ram_));
}

LumenPart& LumenParts::whole() {
    VoxelSet& all = parts_.front().grown.voxels;
    for (; parts_.size() > 1; parts_.pop_back()) {
        const VoxelSet& more = parts_.back().grown.voxels;
        for (const std::size_t chunk : more.filledChunks()) {
            ChunkRows rows;
            for (int row = 0; row < kRowsPerChunk; ++row)
                rows[static_cast<std::size_t>(row)] = all.row(chunk, row) | more.row(chunk, row);
            all.setChunk(chunk, rows);
        }
        parts_.front().grown.count += parts_.back().grown.count;
    }
    return parts_.front();
}

const LumenGraph& LumenParts::graphOf(LumenPart& part, std::uint64_t mostBlocks) {
    if (!part.graph)
        part.graph.emplace(part.grown.voxels, info_.spacingMm(), mostBlocks, ram_);
    return *part.graph;
}

std::vector<glm::ivec3> LumenParts::way(LumenPart& part, const glm::ivec3& from,
                                        const std::optional<glm::ivec3>& to) {
    progress_.stage("searching the path");
    const LumenGraph& graph = graphOf(part);
    const std::array<LumenNode, 1> root = {graph.nodeAt(from)};
    std::vector<float> costs;
    LumenNode end = to ? graph.nodeAt(*to) : kNoNode;
    {
        const LumenReach lengths = searchLumen(graph, root, {}, ram_);
        if (!to)
            end = lengths.farthest();
        // one and a half times the width at its ends; adjoining organs are wider than that
        float widest = 0;
        for (const glm::ivec3& seed : {from, to.value_or(from)})
            widest = std::max(widest,
                              widestNear(graph, seed, part.shape.roughRadiusMm(part.shape.middleOf(seed))));
        costs = costsPerMm(graph, lengths.cost, 1.5F * widest);
    }
    const LumenReach reach =
        searchLumen(graph, root, costs, ram_, [end](LumenNode node) { return node == end; });
    std::vector<LumenNode> path = reach.pathTo(end);
    if (!to)
        leaveCorner(graph, path);
    return graph.voxelChain(path, from, to ? *to : graph.someVoxel(path.back()));
}

} // namespace tessera
