// bricking/analysis/body/mark_distance.cpp: see mark_distance.h.
#include "bricking/analysis/body/mark_distance.h"

#include "core/base/brick.h"
#include "core/base/threads.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <vector>

namespace tessera {
namespace {

using Word = Marks::Word;

/// Of two voxels so many samples apart along an axis, added to that along the axes before.
float plusSquare(double spacingMm, int apart, float before) {
    const auto away = static_cast<double>(apart);
    return static_cast<float>(spacingMm * spacingMm * away * away + static_cast<double>(before));
}

/// The ball of a distance, by rows: the farthest voxel along x, or -1.
class Ball {
  public:
    Ball(const glm::ivec3& extent, const glm::dvec3& spacingMm, double mostMm2) {
        const auto radius = [&](int axis) {
            int most = -1;
            while (most + 1 < extent[axis] &&
                   static_cast<double>(plusSquare(spacingMm[axis], most + 1, 0)) <= mostMm2)
                ++most;
            return most;
        };
        const int x = radius(0);
        rows_ = radius(1), slices_ = radius(2);
        for (int dz = 0; dz <= slices_; ++dz)
            for (int dy = 0; dy <= rows_; ++dy) {
                int reach = x;
                while (reach >= 0) {
                    const float inRow = plusSquare(spacingMm.x, reach, 0);
                    const float inSlice = plusSquare(spacingMm.y, dy, inRow);
                    if (static_cast<double>(plusSquare(spacingMm.z, dz, inSlice)) <= mostMm2)
                        break;
                    --reach;
                }
                reach_.push_back(reach);
            }
    }
    int rows() const { return rows_; }
    int slices() const { return slices_; }
    int reach(int dy, int dz) const { return reach_[static_cast<std::size_t>(dz * (rows_ + 1) + dy)]; }

  private:
    int rows_ = -1, slices_ = -1;
    std::vector<int> reach_;
};

/// Adds the neighbours of all bits of a row.
void widen(std::span<Word> row, Word lastWord) {
    Word before = 0; // the word before, as it was
    for (std::size_t i = 0; i < row.size(); ++i) {
        const Word word = row[i], next = i + 1 < row.size() ? row[i + 1] : 0;
        row[i] =
            word | word << 1 | before >> (Marks::kWordBits - 1) | word >> 1 | next << (Marks::kWordBits - 1);
        before = word;
    }
    row.back() &= lastWord;
}

} // namespace

Marks within(const Marks& marks, const glm::dvec3& spacingMm, double mostMm2, int threads) {
    const glm::ivec3& extent = marks.extent();
    const Ball ball(extent, spacingMm, mostMm2);
    Marks near(extent);
    parallelFor(static_cast<std::size_t>(extent.z), threads, [&](std::size_t slice) {
        const int z = static_cast<int>(slice);
        std::vector<Word> wide(static_cast<std::size_t>(marks.rowWords()));
        const auto addTo = [&](int y) {
            if (y < 0 || y >= extent.y)
                return;
            const std::span<Word> to = near.row(near.rowNumber(y, z));
            for (std::size_t i = 0; i < wide.size(); ++i)
                to[i] |= wide[i];
        };
        for (int from = std::max(z - ball.slices(), 0); from <= std::min(z + ball.slices(), extent.z - 1);
             ++from)
            for (int y = 0; y < extent.y; ++y) {
                const std::span<const Word> row = marks.row(marks.rowNumber(y, from));
                if (std::all_of(row.begin(), row.end(), [](Word word) { return word == 0; }))
                    continue;
                std::copy(row.begin(), row.end(), wide.begin());
                int reached = 0;
                for (int dy = ball.rows(); dy >= 0; --dy) { // rows that are nearer reach farther
                    const int reach = ball.reach(dy, std::abs(from - z));
                    if (reach < 0)
                        continue;
                    for (; reached < reach; ++reached)
                        widen(wide, marks.lastWord());
                    addTo(y - dy);
                    if (dy > 0)
                        addTo(y + dy);
                }
            }
    });
    return near;
}

namespace {

/// Samples between a place of a row and the nearest clear bit, at most `most`; more than that if there is
/// none.
int nearestClear(std::span<const Word> row, int extent, int x, int most) {
    const auto wordAt = [&](int n) { return ~row[static_cast<std::size_t>(n)]; };
    const int at = x / Marks::kWordBits, bit = x % Marks::kWordBits;
    int nearest = most + 1;
    const Word up = wordAt(at) >> bit;
    if (up != 0)
        nearest = std::min(nearest, std::countr_zero(up));
    for (int n = at + 1; up == 0 && n < static_cast<int>(row.size()); ++n) {
        const int start = n * Marks::kWordBits;
        if (start - x > nearest)
            break;
        if (wordAt(n) != 0) {
            nearest = std::min(nearest, start + std::countr_zero(wordAt(n)) - x);
            break;
        }
    }
    if (x + nearest >= extent) // beyond the row is no voxel
        nearest = most + 1;
    const Word down = wordAt(at) << (Marks::kWordBits - 1 - bit);
    if (down != 0)
        return std::min(nearest, std::countl_zero(down));
    for (int n = at - 1; n >= 0; --n) {
        const int last = n * Marks::kWordBits + Marks::kWordBits - 1;
        if (x - last > nearest)
            break;
        if (wordAt(n) != 0)
            return std::min(nearest, x - last + std::countl_zero(wordAt(n)));
    }
    return nearest;
}

/// A depth, and the voxel that it was measured to.
struct Depth {
    float squareMm2 = kFarAway;
    glm::ivec3 nearest{-1};
};

class Depths {
  public:
    Depths(const Marks& marks, const glm::dvec3& spacingMm) : marks_(marks), spacing_(spacingMm) {}

    float between(const glm::ivec3& a, const glm::ivec3& b) const {
        const glm::ivec3 apart = glm::abs(a - b);
        return plusSquare(spacing_.z, apart.z,
                          plusSquare(spacing_.y, apart.y, plusSquare(spacing_.x, apart.x, 0)));
    }
    /// The depth at a voxel, or the first that is found of at most `enough`.
    /// @param known  of any voxel that is not marked
    Depth at(const glm::ivec3& voxel, float enough, Depth known) const {
        if (!marks_.has(voxel))
            return {0, voxel};
        const glm::ivec3& extent = marks_.extent();
        Depth best = known;
        const auto look = [&](int dy, int dz, float bound) {
            const int y = voxel.y + dy, z = voxel.z + dz;
            if (y < 0 || y >= extent.y)
                return;
            const auto room = std::sqrt(static_cast<double>(best.squareMm2 - bound)) / spacing_.x;
            const int most = room < extent.x ? static_cast<int>(room) + 1 : extent.x;
            const int dx = nearestClear(marks_.row(marks_.rowNumber(y, z)), extent.x, voxel.x, most);
            if (dx > most)
                return;
            const float found =
                plusSquare(spacing_.z, dz, plusSquare(spacing_.y, dy, plusSquare(spacing_.x, dx, 0)));
            if (found < best.squareMm2) {
                const bool isBefore = voxel.x >= dx && !marks_.has({voxel.x - dx, y, z});
                best = {found, {isBefore ? voxel.x - dx : voxel.x + dx, y, z}};
            }
        };
        const auto lookAlong = [&](int dz) {
            if (voxel.z + dz < 0 || voxel.z + dz >= extent.z)
                return;
            for (int dy = 0; dy < extent.y && best.squareMm2 > enough; ++dy) {
                const float bound = plusSquare(spacing_.z, dz, plusSquare(spacing_.y, dy, 0));
                if (bound >= best.squareMm2)
                    break;
                look(-dy, dz, bound);
                if (dy > 0)
                    look(dy, dz, bound);
            }
        };
        for (int dz = 0; dz < extent.z && best.squareMm2 > enough; ++dz) {
            if (plusSquare(spacing_.z, dz, 0) >= best.squareMm2)
                break;
            lookAlong(-dz);
            if (dz > 0)
                lookAlong(dz);
        }
        return best;
    }

  private:
    const Marks& marks_;
    const glm::dvec3& spacing_;
};

/// The voxels of a cube that lie in the volume, and what is known of a depth there.
struct Block {
    glm::ivec3 low;
    glm::ivec3 nearest; // a voxel that is not marked
};

} // namespace

namespace {

constexpr int kLargestBlock = 16, kListedBlock = 4; // smaller ones are looked at as they come

/// Finds the deepest voxel, block by block.
class DeepestVoxel {
  public:
    DeepestVoxel(const Marks& marks, const glm::dvec3& spacingMm)
        : extent_(marks.extent()), spacingMm_(spacingMm), depths_(marks, spacingMm) {}

    float find() {
        std::vector<Block> blocks, finer;
        forEachCube(glm::ivec3(0), extent_, kLargestBlock, glm::ivec3(-1),
                    [&](const Block& b) { finer.push_back(b); });
        for (int edge = kLargestBlock; edge > kListedBlock; edge /= 2) {
            blocks.swap(finer);
            finer.clear();
            for (const Block& block : blocks)
                visit(block, edge, [&](const Block& b) { finer.push_back(b); });
        }
        for (const Block& block : finer)
            descend(block, kListedBlock);
        return isFarAway_ ? kFarAway : largest_;
    }

  private:
    template <typename Add>
    static void forEachCube(const glm::ivec3& first, const glm::ivec3& end, int edge,
                            const glm::ivec3& nearest, const Add& add) {
        for (int z = first.z; z < end.z; z += edge)
            for (int y = first.y; y < end.y; y += edge)
                for (int x = first.x; x < end.x; x += edge)
                    add(Block{{x, y, z}, nearest});
    }
    /// Adds the halves of a block that may hold the deepest voxel.
    template <typename Add> void visit(const Block& block, int edge, const Add& add) {
        constexpr double kRounding = 1 + 1e-5; // of sums in float
        const glm::ivec3 end = glm::min(block.low + edge, extent_), middle = (block.low + end - 1) / 2;
        // No voxel of the block is deeper than its middle by more than this.
        const double more = glm::length(glm::dvec3(end - 1 - middle) * spacingMm_) * kRounding;
        const double least = std::sqrt(static_cast<double>(largest_)) - more;
        const float enough = edge == 1   ? largest_
                             : least > 0 ? static_cast<float>(least * least / kRounding)
                                         : -1;
        Depth known;
        if (block.nearest.x >= 0)
            known = {depths_.between(middle, block.nearest), block.nearest};
        const Depth depth = depths_.at(middle, enough, known);
        isFarAway_ = isFarAway_ || depth.nearest.x < 0;
        if (isFarAway_ || depth.squareMm2 <= enough)
            return;
        largest_ = std::max(largest_, depth.squareMm2);
        if (edge > 1)
            forEachCube(block.low, end, edge / 2, depth.nearest, add);
    }
    void descend(const Block& block, int edge) {
        visit(block, edge, [&](const Block& b) { descend(b, edge / 2); });
    }

    glm::ivec3 extent_;
    glm::dvec3 spacingMm_;
    Depths depths_;
    float largest_ = 0;
    bool isFarAway_ = false;
};

} // namespace

std::size_t depthBytes(const glm::ivec3& extent) {
    const auto blocks = [&](int edge) { return cellCount(ceilDiv(extent, edge)) * sizeof(Block); };
    return 2 * (blocks(kListedBlock) + blocks(2 * kListedBlock)); // lists grow by doubling
}

float largestDepth(const Marks& marks, const glm::dvec3& spacingMm) {
    return marks.any() ? DeepestVoxel(marks, spacingMm).find() : 0;
}

} // namespace tessera
