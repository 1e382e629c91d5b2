// tests/support/blobs.h: bricks of random blobs, and their sampled rays.
#pragma once

#include "bricking/levels/level_error.h"
#include "bricking/statistics/brick_rays.h"
#include "tests/support/bricking_selection_tools.h" // uniform

#include <cmath>
#include <vector>

namespace tessera::test {

/// A brick of random blobs with its coarser levels by plain averaging; no neighbours.
struct Blobs {
    glm::ivec3 size;
    std::array<glm::ivec3, kLevelCount> extents;
    std::array<std::vector<float>, kLevelCount> levels;

    Blobs(const glm::ivec3& n, std::uint64_t seed) : size(n) {
        for (int level = 0; level < kLevelCount; ++level) {
            const auto at = static_cast<std::size_t>(level);
            const glm::ivec3 e = extents[at] = levelExtent(n, level);
            levels[at].resize(cellCount(e));
            for (int z = 0; z < e.z; ++z)
                for (int y = 0; y < e.y; ++y)
                    for (int x = 0; x < e.x; ++x) {
                        float& out = levels[at][linearIndex({x, y, z}, e)];
                        if (level == 0) {
                            const double phase = uniform(seed) * 6;
                            out = static_cast<float>(100 * std::sin(0.3 * x + phase) *
                                                         std::cos(0.2 * y + 0.1 * z) +
                                                     40 * uniform(seed + linearIndex({x, y, z}, e)));
                            continue;
                        }
                        const glm::ivec3 f = extents[at - 1];
                        double sum = 0;
                        for (int c = 0; c < 8; ++c)
                            sum += static_cast<double>(levels[at - 1][linearIndex(
                                glm::min(2 * glm::ivec3(x, y, z) + glm::ivec3(c & 1, c >> 1 & 1, c >> 2),
                                         f - 1),
                                f)]);
                        out = static_cast<float>(sum / 8);
                    }
        }
    }
    BrickFields fields() const {
        BrickFields out;
        out.size = size;
        out.voxels = levels[0];
        for (std::size_t level = 1; level < kLevelCount; ++level)
            out.levels[level] = {glm::ivec3(0), extents[level], levels[level]};
        return out;
    }
};

inline BrickRays raysOf(const std::vector<Blobs>& bricks, const glm::ivec3& grid) {
    BrickRays rays;
    rays.bricks = grid;
    rays.pages.emplace_back(BrickRays::kRowsPerPage * rays.rowBytes());
    for (const Blobs& b : bricks) {
        const auto parts = sampleRays(b.fields());
        const auto row = rays.row(static_cast<std::uint32_t>(rays.rows));
        for (std::size_t part = 0; part < parts.size(); ++part)
            encode(parts[part], std::span<std::uint8_t, kBrickRayBytes>(row.data() + part * kBrickRayBytes,
                                                                        kBrickRayBytes));
        rays.rowOf.push_back(static_cast<std::uint32_t>(rays.rows++));
    }
    return rays;
}

} // namespace tessera::test
