// tests/support/lumen_tubes.h: volumes with tubes for centre-lines, as chunks that are made when they are
// read: no store, any size. And how far lines lie apart.
#pragma once

#include "bricking/cache/chunk_source.h"
#include "core/animation/path.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <functional>
#include <glm/geometric.hpp>
#include <vector>

namespace tessera::test {

/// HU at a place of patient space, mm.
using Field = std::function<double(const glm::dvec3&)>;

/// A field sampled at voxel centres as int16, level 0 alone.
class FieldChunks final : public ChunkSource {
  public:
    FieldChunks(const VolumeInfo& info, Field field) : info_(info), field_(std::move(field)) {}
    const VolumeInfo& info() const override { return info_; }
    void readChunk(const ChunkKey& key, std::span<std::byte> out) const override {
        ++read_;
        if (onRead)
            onRead();
        std::int16_t* at = reinterpret_cast<std::int16_t*>(out.data());
        const glm::ivec3 corner = glm::ivec3(key.i, key.j, key.k) * kChunkExtent;
        for (int z = 0; z < kChunkExtent; ++z)
            for (int y = 0; y < kChunkExtent; ++y)
                for (int x = 0; x < kChunkExtent; ++x) {
                    const glm::dvec3 place = glm::dvec3(corner + glm::ivec3(x, y, z)) + 0.5;
                    *at++ = static_cast<std::int16_t>(
                        std::lround(field_(glm::dvec3(info_.patientFromVoxel * glm::dvec4(place, 1)))));
                }
    }
    int read() const { return read_; }
    std::function<void()> onRead;

  private:
    VolumeInfo info_;
    Field field_;
    mutable std::atomic<int> read_ = 0;
};

/// Axes along the patient's, the first voxel's corner at low.
inline VolumeInfo boxInfo(const glm::ivec3& extent, const glm::dvec3& spacing, const glm::dvec3& low) {
    VolumeInfo info;
    info.extentVoxels = extent;
    info.type = ValueType::i16;
    info.unit = "HU";
    info.patientFromVoxel =
        patientFromVoxelOf(low + 0.5 * spacing, {spacing.x, 0, 0}, {0, spacing.y, 0}, {0, 0, spacing.z});
    return info;
}

inline double segmentDistance(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b) {
    const glm::dvec3 ab = b - a;
    const double t = std::clamp(glm::dot(p - a, ab) / std::max(glm::dot(ab, ab), 1e-12), 0.0, 1.0);
    return glm::length(p - a - t * ab);
}
inline double lineDistance(const glm::dvec3& p, const std::vector<glm::dvec3>& line) {
    double best = 1e300;
    for (std::size_t i = 0; i + 1 < line.size(); ++i)
        best = std::min(best, segmentDistance(p, line[i], line[i + 1]));
    return best;
}

struct Apart {
    double mean = 0, most = 0;
};
inline Apart apart(const std::vector<glm::dvec3>& points, const std::vector<glm::dvec3>& line) {
    Apart found;
    for (const glm::dvec3& p : points) {
        const double away = lineDistance(p, line);
        found.mean += away / static_cast<double>(points.size());
        found.most = std::max(found.most, away);
    }
    return found;
}

/// Air in tissue: a tube of a radius along a line, its edge blended over `soft` mm.
inline Field tube(std::vector<glm::dvec3> line, double radius, double soft, double inside = -1000,
                  double outside = 40) {
    return [=](const glm::dvec3& p) {
        const double share = std::clamp((lineDistance(p, line) - radius) / soft + 0.5, 0.0, 1.0);
        return inside + share * (outside - inside);
    };
}

} // namespace tessera::test
