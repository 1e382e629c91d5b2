// datasets/branching_tree.h: trees that fill a region, for airways and vessels. A branch grows towards the
// centre of the points that it serves. The points are then split into two halves, each served by a child.
// Radii follow Murray's law.
#pragma once

#include "datasets/shapes.h"

#include <functional>

namespace tessera {

struct TreeRules {
    float rootRadiusMm = 5;
    float tipRadiusMm = 0.7F; ///< no branch is thinner
    float reach = 0.42F;      ///< length of a branch, as a share of the way to the points' centre
    float murray = 2.7F;      ///< radius^murray is divided among the children
    float shortestMm = 3;     ///< a branch shorter than this ends the tree
    int generations = 14;
};

/// Jittered points of a cubic lattice of the given pitch where inside() holds; the same for the same seed.
std::vector<glm::vec3> scatter(const Box& box, float pitchMm, std::uint32_t seed,
                               const std::function<bool(const glm::vec3&)>& inside);
/// One tube of a tree.
struct TreeBranch {
    Knot from, to;
    int parent = -1;    ///< its index in the list; -1: begins at the root
    int generation = 0; ///< forks between the root and it
};

/// The tubes of a tree that serves the points, from root on, each after its parent.
std::vector<TreeBranch> growTree(const glm::vec3& root, std::vector<glm::vec3> points,
                                 const TreeRules& rules);
/// Adds the tree's tubes.
void addTree(ShapeList& shapes, const std::vector<TreeBranch>& tree, float voxelMm);

} // namespace tessera
