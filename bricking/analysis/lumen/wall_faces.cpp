// bricking/analysis/lumen/wall_faces.cpp: see wall_faces.h.
#include "bricking/analysis/lumen/wall_faces.h"

#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>

namespace tessera {
namespace {

constexpr double kAround = 2.5; // voxels

glm::dvec3 faceFromVoxel(int side) {
    return 0.5 * glm::dvec3(sideStep(side));
}

} // namespace

WallFaces::WallFaces(const VoxelSet& voxels, const glm::dmat4& patientFromVoxel)
    : voxels_(voxels), voxelFromMm_(glm::inverse(glm::dmat3(patientFromVoxel))),
      covector_(glm::transpose(voxelFromMm_)),
      voxelMm3_(std::abs(glm::determinant(glm::dmat3(patientFromVoxel)))) {
    for (int side = 0; side < kSides; ++side)
        for (int z = -4; z <= 4; ++z)
            for (int y = -4; y <= 4; ++y)
                for (int x = -4; x <= 4; ++x) {
                    // weights that fall to 0: a ball with a hard edge would bias normals to the voxels' axes
                    const glm::dvec3 away = glm::dvec3(x, y, z) - faceFromVoxel(side);
                    const double weight = 1 - glm::dot(away, away) / (kAround * kAround);
                    if (weight > 0)
                        around_[static_cast<std::size_t>(side)].push_back({{x, y, z}, weight * away});
                }
}

std::uint32_t WallFaces::bits(const glm::ivec3& chunk, int row, int side) const {
    const glm::ivec3 &n = voxels_.extentVoxels(), grid = voxels_.chunks();
    const std::uint32_t own = voxels_.row(linearIndex(chunk, grid), row);
    if (!own)
        return 0;
    if (side >= 2) {
        const glm::ivec3 v = kChunkExtent * chunk + glm::ivec3(0, row & 31, row >> 5) + sideStep(side);
        if (v.y < 0 || v.z < 0 || v.y >= n.y || v.z >= n.z)
            return 0;
        return own &
               ~voxels_.row(linearIndex({chunk.x, v.y >> 5, v.z >> 5}, grid), (v.y & 31) + 32 * (v.z & 31));
    }
    const int next = chunk.x + (side ? 1 : -1);
    const bool none = next < 0 || next >= grid.x;
    const std::uint32_t beside = none ? 0 : voxels_.row(linearIndex({next, chunk.y, chunk.z}, grid), row);
    if (side == 0)
        return own & ~(own << 1 | (none ? 1u : beside >> 31));
    std::uint32_t upper = own >> 1 | beside << 31;
    if (const int last = n.x - 1 - kChunkExtent * chunk.x; last < kChunkExtent)
        upper |= 1u << last; // as if the lumen continued
    return own & ~upper;
}

WallFaces::Face WallFaces::at(const glm::ivec3& voxel, int side) const {
    const glm::dvec3 toFace = faceFromVoxel(side);
    const glm::ivec3 last = voxels_.extentVoxels() - 1;
    glm::dvec3 inward(0); // moment of the lumen around the face: for a plane at right angles to it
    for (const Neighbour& near : around_[static_cast<std::size_t>(side)])
        if (voxels_.contains(glm::clamp(voxel + near.offset, glm::ivec3(0), last)))
            inward += near.moment;
    Face face;
    face.middle = glm::dvec3(voxel) + 0.5 + toFace;
    const glm::dvec3 own = covector_ * glm::dvec3(sideStep(side));
    face.outward = glm::normalize(glm::length(inward) > 1e-6 ? covector_ * -inward : own);
    face.areaMm2 = std::max(0.0, voxelMm3_ * glm::dot(own, face.outward));
    const glm::dvec3 up = -glm::normalize(voxelFromMm_ * face.outward);
    face.above = face.middle + up;
    for (const double part : {0.5, 0.8})
        if (voxels_.containsPlace(face.above = face.middle + part * up))
            return face;
    face.above = glm::dvec3(voxel) + 0.5;
    return face;
}

bool seesThrough(const VoxelSet& voxels, const glm::dvec3& from, const glm::dvec3& to) {
    glm::ivec3 at(glm::floor(from));
    const glm::ivec3 end(glm::floor(to));
    const glm::dvec3 way = to - from;
    glm::ivec3 step(0);
    glm::dvec3 next(std::numeric_limits<double>::infinity()), pace(0); // shares of the way
    int steps = 0;
    for (int axis = 0; axis < 3; ++axis) {
        steps += std::abs(end[axis] - at[axis]);
        if (end[axis] == at[axis])
            continue;
        step[axis] = end[axis] > at[axis] ? 1 : -1;
        pace[axis] = 1 / std::abs(way[axis]);
        next[axis] = (step[axis] > 0 ? at[axis] + 1 - from[axis] : from[axis] - at[axis]) * pace[axis];
    }
    for (;; --steps) {
        if (!voxels.contains(at))
            return false;
        if (steps == 0)
            return true;
        const int axis = next.x <= next.y ? (next.x <= next.z ? 0 : 2) : (next.y <= next.z ? 1 : 2);
        at[axis] += step[axis];
        next[axis] =
            at[axis] == end[axis] ? std::numeric_limits<double>::infinity() : next[axis] + pace[axis];
    }
}

} // namespace tessera
