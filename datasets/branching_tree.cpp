// datasets/branching_tree.cpp: see branching_tree.h.
#include "datasets/branching_tree.h"

#include <algorithm>
#include <span>

namespace tessera {
namespace {

/// Direction in which the points spread most: power iteration on their covariance.
glm::vec3 mainSpread(std::span<const glm::vec3> points, const glm::vec3& middle) {
    glm::vec3 axis = glm::normalize(glm::vec3(1, 0.7F, 0.4F));
    for (int round = 0; round < 8; ++round) {
        glm::vec3 next(0);
        for (const glm::vec3& p : points)
            next += glm::dot(p - middle, axis) * (p - middle);
        const float length = glm::length(next);
        if (length < 1e-6F)
            return axis;
        axis = next / length;
    }
    return axis;
}

void grow(std::vector<TreeBranch>& tree, const glm::vec3& from, float radius, std::span<glm::vec3> points,
          const TreeRules& rules, int parent, int generation) {
    glm::vec3 middle(0);
    for (const glm::vec3& p : points)
        middle += p;
    middle /= static_cast<float>(points.size());
    const bool tip = points.size() < 2 || generation >= rules.generations;
    const glm::vec3 to = tip ? middle : from + rules.reach * (middle - from);
    if (glm::length(to - from) < rules.shortestMm && tip)
        return;
    const float endRadius = std::max(rules.tipRadiusMm, tip ? 0.7F * radius : 0.92F * radius);
    const int self = static_cast<int>(tree.size());
    tree.push_back({{from, radius}, {to, endRadius}, parent, generation});
    if (tip)
        return;
    const glm::vec3 axis = mainSpread(points, middle);
    const std::size_t half = points.size() / 2;
    std::nth_element(
        points.begin(), points.begin() + static_cast<std::ptrdiff_t>(half), points.end(),
        [&](const glm::vec3& a, const glm::vec3& b) { return glm::dot(a, axis) < glm::dot(b, axis); });
    for (const std::span<glm::vec3> part : {points.subspan(0, half), points.subspan(half)}) {
        const float share = static_cast<float>(part.size()) / static_cast<float>(points.size());
        const float child = std::max(rules.tipRadiusMm, radius * std::pow(share, 1 / rules.murray));
        grow(tree, to, child, part, rules, self, generation + 1);
    }
}

} // namespace

std::vector<glm::vec3> scatter(const Box& box, float pitchMm, std::uint32_t seed,
                               const std::function<bool(const glm::vec3&)>& inside) {
    std::vector<glm::vec3> points;
    const glm::ivec3 count(glm::ceil((box.high - box.low) / pitchMm));
    std::uint32_t cell = 0;
    for (int k = 0; k < count.z; ++k)
        for (int j = 0; j < count.y; ++j)
            for (int i = 0; i < count.x; ++i, ++cell) {
                const glm::vec3 jitter(hashUnit(cell, seed, 1), hashUnit(cell, seed, 2),
                                       hashUnit(cell, seed, 3));
                const glm::vec3 p = box.low + pitchMm * (glm::vec3(i, j, k) + jitter);
                if (inside(p))
                    points.push_back(p);
            }
    return points;
}

std::vector<TreeBranch> growTree(const glm::vec3& root, std::vector<glm::vec3> points,
                                 const TreeRules& rules) {
    std::vector<TreeBranch> tree;
    if (!points.empty())
        grow(tree, root, rules.rootRadiusMm, points, rules, -1, 0);
    return tree;
}

void addTree(ShapeList& shapes, const std::vector<TreeBranch>& tree, float voxelMm) {
    for (const TreeBranch& branch : tree)
        shapes.push_back(std::make_unique<TubeSegment>(branch.from.at, branch.to.at, branch.from.radiusMm,
                                                       branch.to.radiusMm, voxelMm));
}

} // namespace tessera
