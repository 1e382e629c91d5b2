// bricking/analysis/lumen/lumen_tree.cpp: the branches of a lumen, and the lines between its forks. See
// lumen_tree.h.
#include "bricking/analysis/lumen/lumen_tree.h"

#include "bricking/analysis/lumen/smooth_line.h"
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

namespace {

constexpr double kAtRoot = 1.5; // radii: branches that leave the first one nearer to the seed begin there too

struct Centred {
    CentredLine line;
    int parent = -1;
    double leavesAtMm = 0;           // along the parent
    std::vector<double> forks;       // positions of forks along it, ascending
    std::vector<std::size_t> pieces; // numbers of its lines
};

glm::dvec3 along(const CentredLine& line, double mm) {
    return pointAt(line.mm, std::clamp(mm / line.spacingMm, 0.0, static_cast<double>(line.mm.size() - 1)),
                   true);
}

double numberAt(const std::vector<double>& numbers, double place) {
    const auto i = std::min(static_cast<std::size_t>(place), numbers.size() - 2);
    const double t = place - static_cast<double>(i);
    return (1 - t) * numbers[i] + t * numbers[i + 1];
}

double radiusAlong(const CentredLine& line, double mm) {
    return numberAt(line.radiusMm,
                    std::clamp(mm / line.spacingMm, 0.0, static_cast<double>(line.mm.size() - 1)));
}

double lengthOf(const CentredLine& line) {
    return line.spacingMm * static_cast<double>(line.mm.size() - 1);
}

/// The position on a line nearest to a point, mm along it.
double nearestAlong(const CentredLine& line, const glm::dvec3& mm) {
    std::size_t best = 0;
    for (std::size_t i = 1; i < line.mm.size(); ++i)
        if (glm::length(line.mm[i] - mm) < glm::length(line.mm[best] - mm))
            best = i;
    return line.spacingMm * static_cast<double>(best);
}

/// Merges forks within half a radius of one another.
/// @param mm  along the line; may be changed
void addFork(Centred& limb, double& mm) {
    for (const double fork : limb.forks)
        if (std::abs(fork - mm) < 0.5 * radiusAlong(limb.line, fork)) {
            mm = fork;
            return;
        }
    const double least = 2 * limb.line.spacingMm, most = lengthOf(limb.line) - least;
    mm = most > least ? std::clamp(mm, least, most) : 0.5 * lengthOf(limb.line);
    if (std::find(limb.forks.begin(), limb.forks.end(), mm) == limb.forks.end())
        limb.forks.push_back(mm);
}

/// The piece of a line between two positions, evenly spaced.
/// @param leastMm  closer together points follow no bend
CentreLine piece(const CentredLine& line, double fromMm, double toMm, double leastMm) {
    CentreLine out;
    const double count = std::max(1.0, std::ceil((toMm - fromMm) / line.spacingMm - 1e-6));
    for (double i = 0; i <= count; ++i) {
        const double mm = fromMm + (toMm - fromMm) * i / count;
        out.points.push_back(along(line, mm));
        out.radiusMm.push_back(radiusAlong(line, mm));
    }
    out.spacingMm = (toMm - fromMm) / count;
    if (stepsHold(out.points, out.spacingMm))
        return out;
    // its points lie on other sides of a bend than the line's
    const std::vector<glm::dvec3> points = std::move(out.points);
    const std::vector<double> radii = std::move(out.radiusMm);
    EvenSteps even = evenSteps(points, line.spacingMm, leastMm);
    out.points = std::move(even.mm);
    out.spacingMm = even.spacingMm;
    out.radiusMm.clear();
    for (const double place : even.places)
        out.radiusMm.push_back(numberAt(radii, place));
    return out;
}

} // namespace

LumenBranches branchLines(const LumenGraph& graph, const std::vector<LumenLimb>& limbs,
                          const LumenShape& shape, LumenValues& values, const LumenRule& rule,
                          double spacingMm, int generations, const std::function<void(double)>& shareDone) {
    std::vector<Centred> centred(limbs.size());
    LumenBranches out;
    out.leastTurnMm = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < limbs.size(); ++i) {
        checkInterrupted();
        if (shareDone)
            shareDone(static_cast<double>(i) / static_cast<double>(limbs.size()));
        const LumenLimb& limb = limbs[i];
        Centred& own = centred[i];
        own.parent = limb.parent;
        const glm::ivec3 from = graph.someVoxel(limb.nodes.front()), to = graph.someVoxel(limb.nodes.back());
        ChainPiece chain;
        CentringRules rules;
        rules.spacingMm = spacingMm;
        if (limb.parent >= 0) { // from the parent's line on
            Centred& parent = centred[static_cast<std::size_t>(limb.parent)];
            own.leavesAtMm = nearestAlong(parent.line, shape.middleOf(from));
            if (limb.parent == 0 && own.leavesAtMm < kAtRoot * parent.line.radiusMm.front()) {
                own.parent = -1;
                own.leavesAtMm = 0;
            } else
                addFork(parent, own.leavesAtMm);
            chain.mm.push_back(along(parent.line, own.leavesAtMm));
            rules.holdFirst = true;
        }
        LumenRule here = rule; // a thin branch's lumen extends as far as the path through it
        for (const glm::ivec3& voxel : graph.voxelChain(limb.nodes, from, to)) {
            chain.mm.push_back(shape.middleOf(voxel));
            here = here.orTaking(values.voxel(voxel));
        }
        own.line = centrePath(shape, {chain}, values, here, rules);
        out.leastTurnMm = std::min(out.leastTurnMm, own.line.leastTurnMm);
    }
    // parents first: a branch's pieces between its forks, each the child of the one before
    for (Centred& limb : centred) {
        std::sort(limb.forks.begin(), limb.forks.end());
        int before = -1, generation = 0;
        if (limb.parent >= 0) {
            const Centred& parent = centred[static_cast<std::size_t>(limb.parent)];
            const auto fork = static_cast<std::size_t>(
                std::find(parent.forks.begin(), parent.forks.end(), limb.leavesAtMm) - parent.forks.begin());
            if (fork >= parent.pieces.size())
                continue; // of too many generations
            before = static_cast<int>(parent.pieces[fork]);
            generation = out.generations[parent.pieces[fork]] + 1;
        }
        double at = 0;
        for (std::size_t k = 0; k <= limb.forks.size() && generation <= generations; ++k, ++generation) {
            const double end = k < limb.forks.size() ? limb.forks[k] : lengthOf(limb.line);
            CentreLine line = piece(limb.line, at, end, 0.25 * shape.smallestSpacingMm());
            line.name = "generation " + std::to_string(generation);
            if (before >= 0) {
                line.parent = static_cast<std::size_t>(before);
                line.leavesAtMm = out.lines[*line.parent].lengthMm();
            }
            before = static_cast<int>(out.lines.size());
            limb.pieces.push_back(out.lines.size());
            out.lines.push_back(std::move(line));
            out.generations.push_back(generation);
            at = end;
        }
    }
    return out;
}

} // namespace tessera
