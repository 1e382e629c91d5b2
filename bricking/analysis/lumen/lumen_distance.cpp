// bricking/analysis/lumen/lumen_distance.cpp: distances of a lumen's blocks to the outside, and chains of
// voxels through blocks. See lumen_graph.h.
//
// The squared distance is found along one axis after the other (core/base/lower_envelope.h). Nothing behind
// the first block outside the lumen is nearer than that block. So each run of blocks of the lumen is a
// transform of its own, and nothing is kept for blocks outside.
#include "bricking/analysis/lumen/lumen_graph.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/lower_envelope.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

namespace tessera {
void LumenGraph::measure() {
    const glm::dvec3 pitch = spacing_ * static_cast<double>(extent_);
    const auto whole = static_cast<std::uint32_t>(extent_ * extent_ * extent_);
    const auto counts = [&](LumenNode node) {
        return node != kNoNode && !parted(node) && 2u * filled_[node] >= whole;
    };
    wall_.assign(blocks_.size(), std::numeric_limits<float>::infinity());
    LowerEnvelope envelope;
    std::vector<LumenNode> run;
    std::vector<double> f;
    for (int axis = 0; axis < 3; ++axis)
        for (LumenNode node = 0; node < count(); ++node) {
            if (node % 16384 == 0)
                checkInterrupted();
            if (!counts(node))
                continue;
            glm::ivec3 at = blocks_[node];
            --at[axis];
            if (counts(first(at)))
                continue; // not a run's first
            run.clear();
            for (LumenNode next = node; counts(next); next = first(at)) {
                run.push_back(next);
                at = blocks_[next];
                ++at[axis];
            }
            f.assign(run.size() + 2, 0);
            for (std::size_t i = 0; i < run.size(); ++i)
                f[i + 1] = static_cast<double>(wall_[run[i]]);
            envelope.transform(f, pitch[axis]);
            for (std::size_t i = 0; i < run.size(); ++i)
                wall_[run[i]] = static_cast<float>(f[i + 1]);
        }
    const double least = 0.25 * std::min({pitch.x, pitch.y, pitch.z});
    for (LumenNode node = 0; node < count(); ++node) {
        wall_[node] = counts(node) ? std::sqrt(wall_[node])
                                   : static_cast<float>(least * filled_[node] / static_cast<double>(whole));
        widest_ = std::max(widest_, wall_[node]);
    }
}

void LumenGraph::chainWithin(std::vector<glm::ivec3>& chain, LumenNode node, LumenNode next,
                             const glm::ivec3& to) const {
    const int n = extent_;
    const glm::ivec3 corner = blocks_[node] * n;
    const Rows rows = rowsOf(node);
    const auto has = [n](const Rows& of, const glm::ivec3& local) {
        return of[static_cast<std::size_t>(local.y + n * local.z)] >> local.x & 1u;
    };
    Rows beyond;
    glm::ivec3 out(0);
    if (next != kNoNode) {
        beyond = rowsOf(next);
        out = blocks_[next] - blocks_[node];
    }
    // breadth first, so that it is a shortest chain
    std::vector<int> cameFrom(static_cast<std::size_t>(n * n * n), -1);
    std::vector<int> queue;
    const auto number = [n](const glm::ivec3& local) { return local.x + n * (local.y + n * local.z); };
    const glm::ivec3 start = chain.back() - corner;
    queue.push_back(number(start));
    cameFrom[static_cast<std::size_t>(queue[0])] = queue[0];
    for (std::size_t head = 0; head < queue.size(); ++head) {
        const int at = queue[head];
        const glm::ivec3 local(at % n, at / n % n, at / n / n);
        const glm::ivec3 across = local + out;
        const bool leaves = next != kNoNode &&
                            glm::any(glm::notEqual(across, glm::clamp(across, 0, n - 1))) &&
                            has(beyond, (across + n) % n);
        if (leaves || (next == kNoNode && corner + local == to)) {
            std::vector<glm::ivec3> back;
            for (int v = at; v != queue[0]; v = cameFrom[static_cast<std::size_t>(v)])
                back.push_back(corner + glm::ivec3(v % n, v / n % n, v / n / n));
            chain.insert(chain.end(), back.rbegin(), back.rend());
            if (leaves)
                chain.push_back(corner + across);
            return;
        }
        for (int face = 0; face < 6; ++face) {
            glm::ivec3 beside = local;
            beside[face / 2] += face % 2 ? 1 : -1;
            if (beside[face / 2] < 0 || beside[face / 2] >= n || !has(rows, beside))
                continue;
            int& came = cameFrom[static_cast<std::size_t>(number(beside))];
            if (came < 0) {
                came = at;
                queue.push_back(number(beside));
            }
        }
    }
    TESSERA_CHECK(!"a node hangs together and touches its neighbour");
}

std::vector<glm::ivec3> LumenGraph::voxelChain(std::span<const LumenNode> path, const glm::ivec3& from,
                                               const glm::ivec3& to) const {
    std::vector<LumenNode> byFaces; // diagonal steps go through the full blocks between
    for (const LumenNode node : path) {
        if (!byFaces.empty())
            for (int axis = 0; axis < 3; ++axis) {
                glm::ivec3 at = blocks_[byFaces.back()];
                if (at[axis] == blocks_[node][axis])
                    continue;
                at[axis] = blocks_[node][axis];
                if (at != blocks_[node])
                    byFaces.push_back(first(at));
            }
        byFaces.push_back(node);
    }
    std::vector<glm::ivec3> chain = {from};
    for (std::size_t i = 0; i < byFaces.size(); ++i)
        chainWithin(chain, byFaces[i], i + 1 < byFaces.size() ? byFaces[i + 1] : kNoNode, to);
    return chain;
}

} // namespace tessera
