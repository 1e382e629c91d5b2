// bricking/analysis/lumen/unseen_patches.cpp: see unseen_patches.h. Each edge of a face leads to one other
// face of the wall: around the voxel, straight on, or up a step.
#include "bricking/analysis/lumen/unseen_patches.h"

#include "bricking/analysis/lumen/wall_faces.h"
#include "core/base/interrupt.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <numeric>

namespace tessera {
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
