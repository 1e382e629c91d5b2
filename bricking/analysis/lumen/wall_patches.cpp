// bricking/analysis/lumen/wall_patches.cpp: see wall_patches.h.
#include "bricking/analysis/lumen/wall_patches.h"

#include "core/base/interrupt.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <numeric>

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

// Each edge of a face leads to one other face of the wall: around the voxel, straight on, or up a step.

namespace {

constexpr std::uint32_t kNone = ~0u;

class Joining {
  public:
    Joining(const ChunkFaces& faces, const VoxelSet& voxels, const glm::dmat4& toMm, MemoryBudget& ram)
        : faces_(faces), voxels_(voxels), toMm_(toMm),
          charge_(ram.charge(faces.all.size() * sizeof(std::uint32_t), "the unseen patches")),
          root_(faces.all.size()) {
        std::iota(root_.begin(), root_.end(), 0u);
    }

    std::vector<UnseenPatch> run(double smallestMm2) {
        eachUnseen([&](std::uint32_t face, const glm::ivec3& voxel, int side) {
            for (int turn = 0; turn < kSides; ++turn)
                if (turn >> 1 != side >> 1)
                    if (const std::uint32_t other = beyondEdge(voxel, side, turn);
                        other != kNone && !faces_.all[other].seen())
                        join(face, other);
        });
        // all sums are in the order of faces
        std::vector<Sum> sums;
        std::vector<std::uint32_t> numbers; // by root, of visited ones
        eachUnseen([&](std::uint32_t face, const glm::ivec3& voxel, int side) {
            Sum& sum = sumOf(sums, numbers, rootOf(face));
            const CoverageFace& f = faces_.all[face];
            const double area = static_cast<double>(f.areaMm2), along = static_cast<double>(f.alongMm);
            sum.area += area;
            sum.weight += area + 1e-9;
            sum.place += (area + 1e-9) * middleOf(voxel, side);
            sum.along += (area + 1e-9) * along;
            sum.from = std::min(sum.from, along);
            sum.to = std::max(sum.to, along);
        });
        eachUnseen([&](std::uint32_t face, const glm::ivec3& voxel, int side) {
            Sum& sum = sumOf(sums, numbers, rootOf(face));
            const glm::dvec3 place = middleOf(voxel, side);
            if (const double away = glm::length(place - sum.place / sum.weight); away < sum.nearest) {
                sum.nearest = away;
                sum.middle = place;
            }
        });
        std::vector<UnseenPatch> patches;
        for (const Sum& sum : sums)
            if (sum.area >= smallestMm2)
                patches.push_back({sum.middle, sum.area, sum.along / sum.weight, sum.from, sum.to});
        std::stable_sort(patches.begin(), patches.end(),
                         [](const UnseenPatch& a, const UnseenPatch& b) { return a.areaMm2 > b.areaMm2; });
        return patches;
    }

  private:
    struct Sum {
        double area = 0, weight = 0, along = 0, from = 1e300, to = -1e300, nearest = 1e300;
        glm::dvec3 place{0}, middle{0};
    };
    template <typename Use> void eachUnseen(const Use& use) const {
        for (std::size_t i = 0; i < faces_.chunks.size(); ++i) {
            checkInterrupted();
            const glm::ivec3 corner = kChunkExtent * gridPosition(faces_.chunks[i], voxels_.chunks());
            for (std::size_t f = faces_.first[i]; f < faces_.first[i + 1]; ++f)
                if (const std::uint32_t place = faces_.all[f].place; !(place & CoverageFace::kSeen)) {
                    const int v = static_cast<int>(place >> 3);
                    use(static_cast<std::uint32_t>(f), corner + glm::ivec3(v & 31, v >> 5 & 31, v >> 10),
                        static_cast<int>(place & 7));
                }
        }
    }
    glm::dvec3 middleOf(const glm::ivec3& voxel, int side) const {
        return glm::dvec3(toMm_ * glm::dvec4(glm::dvec3(voxel) + 0.5 + 0.5 * glm::dvec3(sideStep(side)), 1));
    }
    std::uint32_t beyondEdge(const glm::ivec3& voxel, int side, int turn) const {
        const glm::ivec3 on = voxel + sideStep(turn), step = on + sideStep(side);
        if (!voxels_.contains(on))
            return find(voxel, turn);
        return voxels_.contains(step) ? find(step, turn ^ 1) : find(on, side);
    }
    std::uint32_t find(const glm::ivec3& voxel, int side) const {
        const std::size_t chunk = linearIndex(voxel >> 5, voxels_.chunks());
        const auto at = std::lower_bound(faces_.chunks.begin(), faces_.chunks.end(), chunk);
        if (at == faces_.chunks.end() || *at != chunk)
            return kNone;
        const auto i = static_cast<std::size_t>(at - faces_.chunks.begin());
        const auto begin = faces_.all.begin() + static_cast<std::ptrdiff_t>(faces_.first[i]),
                   end = faces_.all.begin() + static_cast<std::ptrdiff_t>(faces_.first[i + 1]);
        const std::uint32_t place = CoverageFace::placeOf(voxel, side);
        const auto found = std::lower_bound(begin, end, place, [](const CoverageFace& f, std::uint32_t p) {
            return (f.place & ~CoverageFace::kSeen) < p;
        });
        return found != end && (found->place & ~CoverageFace::kSeen) == place
                   ? static_cast<std::uint32_t>(found - faces_.all.begin())
                   : kNone;
    }
    std::uint32_t rootOf(std::uint32_t face) {
        while (root_[face] != face)
            face = root_[face] = root_[root_[face]];
        return face;
    }
    void join(std::uint32_t a, std::uint32_t b) {
        a = rootOf(a);
        b = rootOf(b);
        root_[std::max(a, b)] = std::min(a, b); // a patch's root is its first face
    }
    static Sum& sumOf(std::vector<Sum>& sums, std::vector<std::uint32_t>& roots, std::uint32_t root) {
        const auto at = std::lower_bound(roots.begin(), roots.end(), root);
        const auto i = at - roots.begin();
        if (at == roots.end() || *at != root) { // roots come in ascending order, so it is the last
            roots.insert(at, root);
            sums.insert(sums.begin() + i, Sum{});
        }
        return sums[static_cast<std::size_t>(i)];
    }

    const ChunkFaces& faces_;
    const VoxelSet& voxels_;
    const glm::dmat4 toMm_;
    Charge charge_;
    std::vector<std::uint32_t> root_;
};

} // namespace

std::vector<UnseenPatch> unseenPatches(const ChunkFaces& faces, const VoxelSet& voxels,
                                       const glm::dmat4& patientFromVoxel, double smallestMm2,
                                       MemoryBudget& ram) {
    return Joining(faces, voxels, patientFromVoxel, ram).run(smallestMm2);
}

} // namespace tessera
