// tests/bricking/labels/label_lattice_test.cpp: lattices of labels against those of scans, turned and flipped
// in every way; and coarser labels as the votes of their voxels.
#include "bricking/labels/label_majority.h"
#include "bricking/labels/label_volume.h"
#include "bricking/labels/lattice_match.h"
#include "bricking/store/pyramid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <gtest/gtest.h>
#include <map>
#include <random>
#include <span>
#include <tuple>
#include <vector>

namespace tessera {
namespace {

double partOf(std::mt19937& random) {
    return std::uniform_real_distribution<double>(-1, 1)(random);
}

/// A scan's lattice of any shape: turned, sheared, of different spacings.
VolumeInfo anyLattice(std::mt19937& random) {
    VolumeInfo info;
    info.extentVoxels = {3 + static_cast<int>(random() % 20), 3 + static_cast<int>(random() % 20),
                         3 + static_cast<int>(random() % 20)};
    info.patientFromVoxel = glm::dmat4(1);
    for (int axis = 0; axis < 3; ++axis) {
        info.patientFromVoxel[axis] =
            glm::dvec4(0.3 * partOf(random), 0.3 * partOf(random), 0.3 * partOf(random), 0);
        info.patientFromVoxel[axis][axis] = 0.8 + 0.5 * std::abs(partOf(random));
    }
    info.patientFromVoxel[3] = glm::dvec4(90 * partOf(random), 90 * partOf(random), 90 * partOf(random), 1);
    return info;
}

/// The same voxels in another order: axis n of the layer is axis order[n] of the scan, backwards where
/// flipped.
VolumeInfo reordered(const VolumeInfo& scan, const std::array<int, 3>& order,
                     const std::array<bool, 3>& flip) {
    VolumeInfo layer = scan;
    glm::dvec4 origin = scan.patientFromVoxel[3];
    for (int n = 0; n < 3; ++n) {
        const int from = order[static_cast<std::size_t>(n)];
        const bool isFlipped = flip[static_cast<std::size_t>(n)];
        layer.extentVoxels[n] = scan.extentVoxels[from];
        layer.patientFromVoxel[n] = (isFlipped ? -1.0 : 1.0) * scan.patientFromVoxel[from];
        if (isFlipped)
            origin += static_cast<double>(scan.extentVoxels[from]) * scan.patientFromVoxel[from];
    }
    layer.patientFromVoxel[3] = origin;
    return layer;
}

TEST(LatticeMatches, NameTheAxesOfEveryOrder) {
    std::mt19937 random(1);
    for (int round = 0; round < 6; ++round) {
        const VolumeInfo scan = anyLattice(random);
        std::array<int, 3> order = {0, 1, 2};
        do {
            for (unsigned flips = 0; flips < 8; ++flips) {
                const std::array<bool, 3> flip = {(flips & 1) != 0, (flips & 2) != 0, (flips & 4) != 0};
                const VolumeInfo layer = reordered(scan, order, flip);
                const LatticeMatch match = latticeMatch(layer, scan);
                EXPECT_TRUE(match.isSame);
                for (std::size_t n = 0; n < 3; ++n) { // axis n of the layer
                    const auto of = static_cast<std::size_t>(order[n]);
                    EXPECT_EQ(match.axis[of], static_cast<int>(n));
                    EXPECT_EQ(match.isFlipped[of], flip[n]);
                }
                EXPECT_EQ(isSameGrid(layer, scan), order == (std::array<int, 3>{0, 1, 2}) && flips == 0);
                // Moved or enlarged by more than is the same, at any axis.
                for (int axis = 0; axis < 3; ++axis)
                    for (const double side : {-1.0, 1.0}) {
                        VolumeInfo moved = layer;
                        moved.patientFromVoxel[3] += side * 1.5 * kSameVoxels * layer.patientFromVoxel[axis];
                        EXPECT_FALSE(latticeMatch(moved, scan).isSame);
                        EXPECT_FALSE(isSameGrid(moved, layer));
                        moved = layer;
                        moved.patientFromVoxel[3] += side * 0.5 * kSameVoxels * layer.patientFromVoxel[axis];
                        EXPECT_TRUE(latticeMatch(moved, scan).isSame);
                        EXPECT_TRUE(isSameGrid(moved, layer));
                        moved = layer;
                        moved.patientFromVoxel[axis] *=
                            1 + side * 1.5 * kSameVoxels / layer.extentVoxels[axis];
                        EXPECT_FALSE(latticeMatch(moved, scan).isSame);
                        EXPECT_FALSE(isSameGrid(moved, layer));
                        moved = layer;
                        moved.extentVoxels[axis] += static_cast<int>(side);
                        EXPECT_FALSE(latticeMatch(moved, scan).isSame);
                        EXPECT_FALSE(isSameGrid(moved, layer));
                    }
            }
        } while (std::ranges::next_permutation(order).found);
    }
}

/// The votes of the voxels of each coarser one, those at the end once more; the rarest of equals.
template <typename Value> void expectVotes(std::mt19937& random, ValueType type) {
    for (int round = 0; round < 40; ++round) {
        const glm::ivec3 extent(1 + static_cast<int>(random() % 7), 1 + static_cast<int>(random() % 7),
                                1 + static_cast<int>(random() % 7));
        const unsigned values = 2 + random() % 4;
        std::vector<std::uint64_t> voxelsOf(values);
        for (std::uint64_t& count : voxelsOf)
            count = 1 + random() % 3; // some are equal
        std::vector<Value> fine(cellCount(extent)), coarse(cellCount(ceilDiv(extent, 2)));
        for (Value& value : fine)
            value = static_cast<Value>(random() % values);
        majorityRule(voxelsOf).reduce(type, extent, std::as_bytes(std::span(fine)),
                                      std::as_writable_bytes(std::span(coarse)), 1 + round % 2);
        for (std::size_t n = 0; n < coarse.size(); ++n) {
            const glm::ivec3 at = gridPosition(n, ceilDiv(extent, 2));
            std::map<Value, int> votes;
            for (int i = 0; i < 8; ++i) {
                const glm::ivec3 of = glm::min(2 * at + glm::ivec3(i & 1, i >> 1 & 1, i >> 2), extent - 1);
                ++votes[fine[linearIndex(of, extent)]];
            }
            const auto better = [&](const auto& a, const auto& b) { // a loses against b
                return std::make_tuple(a.second, ~voxelsOf[a.first], -a.first) <
                       std::make_tuple(b.second, ~voxelsOf[b.first], -b.first);
            };
            EXPECT_EQ(coarse[n], std::max_element(votes.begin(), votes.end(), better)->first);
        }
    }
}

TEST(LabelMajority, IsTheVotesOfItsVoxels) {
    std::mt19937 random(2);
    expectVotes<std::uint8_t>(random, ValueType::u8);
    expectVotes<std::uint16_t>(random, ValueType::u16);
}

} // namespace
} // namespace tessera
