// bricking/analysis/lumen/lumen_tree.cpp: the branches of a lumen. See lumen_tree.h.
#include "bricking/analysis/lumen/lumen_tree.h"

#include "core/base/interrupt.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

namespace tessera {
namespace {

constexpr double kServed = 1.5; // wall distances around a branch
constexpr double kServedVoxels = 2;
constexpr double kLeastBeyondMm = 3; // of a branch, beyond its parent's wall
constexpr std::size_t kMostLimbs = 5000;

class Limbs {
  public:
    Limbs(const LumenGraph& graph, LumenNode root, MemoryBudget& ram)
        : graph_(graph), ram_(ram),
          charge_(ram.charge(graph.count() * (2 * sizeof(float) + 2 * sizeof(int)), "the branches")),
          limbOf_(graph.count(), -1), served_(graph.count(), false) {
        const std::array<LumenNode, 1> from = {root};
        LumenReach reach = searchLumen(graph, from, {}, ram);
        lengths_ = std::move(reach.cost);
        costs_ = costsPerMm(graph, lengths_, graph.widestMm());
        for (LumenNode node = 0; node < graph.count(); ++node)
            if (std::isfinite(lengths_[node]))
                byLength_.push_back(node);
        std::sort(byLength_.begin(), byLength_.end(), [&](LumenNode a, LumenNode b) {
            return lengths_[a] != lengths_[b] ? lengths_[a] > lengths_[b] : a < b;
        });
        limbOf_[root] = 0;
        served_[root] = true;
    }

    std::vector<LumenLimb> run(const std::function<void(double)>& shareDone) {
        for (std::size_t i = 0; i < byLength_.size() && limbs_.size() < kMostLimbs; ++i) {
            if (served_[byLength_[i]])
                continue;
            checkInterrupted();
            if (shareDone)
                shareDone(static_cast<double>(i) / static_cast<double>(byLength_.size()));
            addLimb(byLength_[i]);
        }
        return std::move(limbs_);
    }

  private:
    void addLimb(LumenNode end) {
        const std::array<LumenNode, 1> from = {end};
        LumenNode at = kNoNode;
        std::vector<LumenNode> nodes;
        {
            const LumenReach reach = searchLumen(graph_, from, costs_, ram_, [&](LumenNode node) {
                at = limbOf_[node] >= 0 ? node : kNoNode;
                return at != kNoNode;
            });
            nodes = reach.pathTo(at); // from the end to an existing branch
        }
        std::reverse(nodes.begin(), nodes.end());
        serve(nodes);
        leaveCorner(graph_, nodes);
        if (!limbs_.empty() && isSpur(nodes))
            return;
        const int limb = static_cast<int>(limbs_.size());
        limbs_.push_back({nodes, limb == 0 ? -1 : limbOf_[at]});
        for (const LumenNode node : nodes)
            if (limbOf_[node] < 0 || limb == 0)
                limbOf_[node] = limb;
    }

    bool isSpur(const std::vector<LumenNode>& nodes) const {
        double beyond = 0, radii = 0, count = 0;
        const double wall = static_cast<double>(graph_.wallMm(nodes.front()));
        const glm::dvec3 begin = graph_.middleMm(nodes.front());
        for (std::size_t i = 1; i < nodes.size(); ++i) {
            if (glm::length(graph_.middleMm(nodes[i]) - begin) <= wall)
                continue; // still within its parent
            beyond += glm::length(graph_.middleMm(nodes[i]) - graph_.middleMm(nodes[i - 1]));
            radii += static_cast<double>(graph_.wallMm(nodes[i]));
            ++count;
        }
        return count == 0 || beyond < std::max(kLeastBeyondMm, 2 * radii / count);
    }

    /// Marks nodes near a branch.
    void serve(const std::vector<LumenNode>& nodes) {
        const double n = graph_.blockExtent();
        const glm::dvec3 pitch = graph_.spacingMm() * n;
        for (const LumenNode node : nodes) {
            served_[node] = true;
            const double reach =
                kServed * static_cast<double>(graph_.wallMm(node)) +
                kServedVoxels * std::max({graph_.spacingMm().x, graph_.spacingMm().y, graph_.spacingMm().z});
            const glm::ivec3 half(glm::floor(reach / pitch)), at = graph_.block(node);
            for (int z = -half.z; z <= half.z; ++z)
                for (int y = -half.y; y <= half.y; ++y)
                    for (int x = -half.x; x <= half.x; ++x)
                        if (glm::length(glm::dvec3(x, y, z) * pitch) <= reach)
                            graph_.eachNode(at + glm::ivec3(x, y, z),
                                            [&](LumenNode near) { served_[near] = true; });
        }
    }

    const LumenGraph& graph_;
    MemoryBudget& ram_;
    Charge charge_;
    std::vector<float> lengths_, costs_;
    std::vector<int> limbOf_;
    std::vector<bool> served_;
    std::vector<LumenNode> byLength_; // furthest first
    std::vector<LumenLimb> limbs_;
};

} // namespace

std::vector<LumenLimb> lumenLimbs(const LumenGraph& graph, LumenNode root, MemoryBudget& ram,
                                  const std::function<void(double)>& shareDone) {
    return Limbs(graph, root, ram).run(shareDone);
}

} // namespace tessera
