// bricking/analysis/body/distance_field.h: the exact distance of every voxel of a small grid to the nearest
// voxel of a set.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

namespace tessera {

/// Squared distances between voxel centres, mm2, in place: 0 marks a voxel of the set, kFarAway any other;
/// without a set voxel all stay kFarAway. x fastest. Source: P. Felzenszwalb and D. Huttenlocher, Distance
/// Transforms of Sampled Functions, 2012: lower envelopes of parabolas, an axis after another.
void squaredDistances(std::vector<float>& grid, const glm::ivec3& extent, const glm::dvec3& spacingMm);
constexpr float kFarAway = 1e30f;

} // namespace tessera
