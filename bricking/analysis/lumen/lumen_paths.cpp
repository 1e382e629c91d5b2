// bricking/analysis/lumen/lumen_paths.cpp: see lumen_paths.h.
#include "bricking/analysis/lumen/lumen_paths.h"

#include "core/base/interrupt.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <queue>

namespace tessera {
namespace {

constexpr float kLeastCost = 0.003F;  // so that no path is free, not even in the centre of the widest place
constexpr float kShareOfRoot = 0.01F; // at the farthest place

} // namespace

std::vector<LumenNode> LumenReach::pathTo(LumenNode node) const {
    std::vector<LumenNode> path;
    for (LumenNode at = node; at != kNoNode; at = before[at])
        path.push_back(at);
    std::reverse(path.begin(), path.end());
    return path;
}

LumenNode LumenReach::farthest() const {
    LumenNode found = kNoNode;
    for (LumenNode node = 0; node < cost.size(); ++node)
        if (reached(node) && (found == kNoNode || cost[node] > cost[found]))
            found = node;
    return found;
}

LumenReach searchLumen(const LumenGraph& graph, std::span<const LumenNode> sources,
                       std::span<const float> perMm, MemoryBudget& ram,
                       const std::function<bool(LumenNode)>& arrived) {
    struct Open {
        float cost;
        LumenNode node;
        bool operator>(const Open& other) const {
            return cost != other.cost ? cost > other.cost : node > other.node;
        }
    };
    LumenReach reach;
    // costs and parents, cost per millimetre, and the queue, in which some nodes occur twice
    reach.charge = ram.charge(graph.count() * (2 * sizeof(float) + sizeof(LumenNode) + 2 * sizeof(Open)),
                              "the search of a path");
    reach.cost.assign(graph.count(), std::numeric_limits<float>::infinity());
    reach.before.assign(graph.count(), kNoNode);
    std::priority_queue<Open, std::vector<Open>, std::greater<>> open;
    for (const LumenNode source : sources) {
        reach.cost[source] = 0;
        open.push({0, source});
    }
    std::vector<LumenStep> steps;
    for (std::uint64_t turn = 0; !open.empty(); ++turn) {
        if (turn % 4096 == 0)
            checkInterrupted();
        const auto [cost, node] = open.top();
        open.pop();
        if (cost > reach.cost[node])
            continue;
        if (arrived && arrived(node))
            break;
        graph.neighbours(node, steps);
        for (const LumenStep& step : steps) {
            const float per = perMm.empty() ? 1 : 0.5F * (perMm[node] + perMm[step.to]);
            const float there = cost + per * step.mm;
            if (there < reach.cost[step.to]) {
                reach.cost[step.to] = there;
                reach.before[step.to] = node;
                open.push({there, step.to});
            }
        }
    }
    return reach;
}

void leaveCorner(const LumenGraph& graph, std::vector<LumenNode>& path) {
    const double pitch =
        graph.blockExtent() * std::max({graph.spacingMm().x, graph.spacingMm().y, graph.spacingMm().z});
    std::size_t best = path.size() - 1;
    double back = 0, atBest = 0; // mm from the end
    for (std::size_t i = path.size() - 1; i > 0; --i) {
        back += glm::length(graph.middleMm(path[i]) - graph.middleMm(path[i - 1]));
        if (back - atBest > 2 * static_cast<double>(graph.wallMm(path[best])) + 2 * pitch)
            break;
        if (graph.wallMm(path[i - 1]) > 1.05F * graph.wallMm(path[best])) {
            best = i - 1;
            atBest = back;
        }
    }
    path.resize(std::max<std::size_t>(best, path.size() > 1 ? 1 : 0) + 1);
}

float widestNear(const LumenGraph& graph, const glm::ivec3& voxel, double reachMm) {
    const glm::dvec3 pitch = graph.spacingMm() * static_cast<double>(graph.blockExtent());
    const glm::ivec3 half(glm::ceil(reachMm / pitch)), at = voxel / graph.blockExtent();
    float widest = 0;
    for (int z = -half.z; z <= half.z; ++z)
        for (int y = -half.y; y <= half.y; ++y)
            for (int x = -half.x; x <= half.x; ++x)
                if (glm::length(glm::dvec3(x, y, z) * pitch) <= reachMm)
                    graph.eachNode(at + glm::ivec3(x, y, z),
                                   [&](LumenNode node) { widest = std::max(widest, graph.wallMm(node)); });
    return widest;
}

std::vector<float> costsPerMm(const LumenGraph& graph, std::span<const float> fromRoot, float widestMm) {
    float farthest = 0;
    for (const float mm : fromRoot)
        if (std::isfinite(mm))
            farthest = std::max(farthest, mm);
    std::vector<float> costs(graph.count());
    for (LumenNode node = 0; node < graph.count(); ++node) {
        const float off = 1 - std::min(graph.wallMm(node) / std::max(widestMm, 1e-6F), 1.0F);
        const float root = std::isfinite(fromRoot[node]) && farthest > 0 ? fromRoot[node] / farthest : 1;
        costs[node] = off * off * off * off + kShareOfRoot * root + kLeastCost;
    }
    return costs;
}

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
