// tests/support/walled_airways.h: a windpipe and its tree in a lung that is nearly as dark, with walls that
// thin out. Leaks occur as in real scans, and every branch's curve is known.
#pragma once

#include "bricking/cache/chunk_source.h"
#include "datasets/branching_tree.h"
#include "tests/support/lumen_tubes.h"

#include <cmath>
#include <vector>

namespace tessera::test {

/// int16 values, HU: air -1000, wall 40, lung -860. Tubes of 6 mm radius down to 1.2 mm, five generations of
/// forks. Their edges are blended over a millimetre, and slices are means over their thickness.
class WalledAirways final : public ChunkSource {
  public:
    /// @param wall  thickness, as a share of the radius, above 0.3 mm
    explicit WalledAirways(double sliceMm, double wall = 0.2) {
        const glm::dvec3 low(-56, -44, -70), high(56, 44, 60);
        const double pitch = 0.8;
        info_ = boxInfo(glm::ivec3((high - low) / glm::dvec3(pitch, pitch, sliceMm)), {pitch, pitch, sliceMm},
                        low);
        TreeRules rules;
        rules.rootRadiusMm = 6;
        rules.tipRadiusMm = 1.2F;
        rules.generations = 5;
        rules.reach = 0.45F;
        const auto inside = [](const glm::vec3& p) {
            const glm::vec3 q = (p - glm::vec3(0, 0, -12)) / glm::vec3(48, 36, 50);
            return glm::dot(q, q) < 1 && std::abs(p.x) > 8;
        };
        tree_ = growTree({0, 0, 57}, scatter({{-50, -40, -64}, {50, 40, 40}}, 13, 5, inside), rules);
        sample(sliceMm, wall);
    }
    const VolumeInfo& info() const override { return info_; }
    const std::vector<TreeBranch>& tree() const { return tree_; }
    static glm::dvec3 seedMm() { return {0, 0, 55}; }
    void readChunk(const ChunkKey& key, std::span<std::byte> out) const override {
        const glm::ivec3 corner = glm::ivec3(key.i, key.j, key.k) * kChunkExtent;
        auto* to = reinterpret_cast<std::int16_t*>(out.data());
        for (int z = 0; z < kChunkExtent; ++z)
            for (int y = 0; y < kChunkExtent; ++y)
                for (int x = 0; x < kChunkExtent; ++x, ++to) {
                    const glm::ivec3 v = corner + glm::ivec3(x, y, z);
                    *to = glm::all(glm::lessThan(v, info_.extentVoxels))
                              ? values_[linearIndex(v, info_.extentVoxels)]
                              : std::int16_t{-1024};
                }
    }
    /// How far a place is from the nearest branch's middle, mm.
    double awayMm(const glm::dvec3& mm) const {
        double away = 1e300;
        for (const TreeBranch& branch : tree_)
            away = std::min(away, segmentDistance(mm, glm::dvec3(branch.from.at), glm::dvec3(branch.to.at)));
        return away;
    }

  private:
    /// Of a fine slice, how far each voxel is outside of the nearest lumen, and of the nearest wall.
    void sample(double sliceMm, double wall) {
        const glm::ivec3 n = info_.extentVoxels;
        const glm::dvec3 mm = info_.spacingMm();
        const int fine = std::max(1, static_cast<int>(std::lround(sliceMm)));
        values_.resize(cellCount(n));
        std::vector<double> lumen(static_cast<std::size_t>(n.x * n.y)), outer(lumen.size()),
            sum(lumen.size());
        for (int z = 0; z < n.z; ++z) {
            std::fill(sum.begin(), sum.end(), 0);
            for (int part = 0; part < fine; ++part) {
                std::fill(lumen.begin(), lumen.end(), 1e3);
                std::fill(outer.begin(), outer.end(), 1e3);
                const double at = -70 + (z + (part + 0.5) / fine) * sliceMm;
                for (const TreeBranch& branch : tree_)
                    blend(branch, at, wall, mm, lumen, outer);
                for (std::size_t i = 0; i < sum.size(); ++i) {
                    const double inWall = std::clamp(0.5 - outer[i], 0.0, 1.0),
                                 inAir = std::clamp(0.5 - lumen[i], 0.0, 1.0);
                    const double tissue = -860 + inWall * 900;
                    sum[i] += (tissue + inAir * (-1000 - tissue)) / fine;
                }
            }
            for (std::size_t i = 0; i < sum.size(); ++i)
                values_[i + static_cast<std::size_t>(z) * sum.size()] =
                    static_cast<std::int16_t>(std::lround(sum[i]));
        }
    }
    void blend(const TreeBranch& branch, double z, double wall, const glm::dvec3& mm,
               std::vector<double>& lumen, std::vector<double>& outer) const {
        const glm::dvec3 a(branch.from.at), b(branch.to.at), ab = b - a;
        const double most = 1.5 * branch.from.radiusMm + 3;
        if (z < std::min(a.z, b.z) - most || z > std::max(a.z, b.z) + most)
            return;
        const glm::ivec3 n = info_.extentVoxels;
        const auto from = [&](double low, double origin) {
            return std::max(0, static_cast<int>((low - most - origin) / mm.x));
        };
        const int x1 = std::min(n.x - 1, static_cast<int>((std::max(a.x, b.x) + most + 56) / mm.x));
        const int y1 = std::min(n.y - 1, static_cast<int>((std::max(a.y, b.y) + most + 44) / mm.y));
        for (int y = from(std::min(a.y, b.y), -44); y <= y1; ++y)
            for (int x = from(std::min(a.x, b.x), -56); x <= x1; ++x) {
                const glm::dvec3 p(-56 + (x + 0.5) * mm.x, -44 + (y + 0.5) * mm.y, z);
                const double t = std::clamp(glm::dot(p - a, ab) / glm::dot(ab, ab), 0.0, 1.0);
                const double radius = branch.from.radiusMm + t * (branch.to.radiusMm - branch.from.radiusMm);
                const double away = glm::length(p - a - t * ab) - radius;
                const auto i = static_cast<std::size_t>(x + n.x * y);
                lumen[i] = std::min(lumen[i], away);
                outer[i] = std::min(outer[i], away - 0.3 - wall * radius);
            }
    }

    VolumeInfo info_;
    std::vector<TreeBranch> tree_;
    std::vector<std::int16_t> values_;
};

} // namespace tessera::test
