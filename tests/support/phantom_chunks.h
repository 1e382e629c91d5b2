// tests/support/phantom_chunks.h: phantoms as chunks, in memory or with noise of any strength put on what any
// source gives, clipped as exports clip it.
#pragma once

#include "bricking/cache/chunk_source.h"
#include "bricking/import/source/slab_source.h"
#include "datasets/phantom.h"

#include <cmath>
#include <cstring>
#include <glm/vector_relational.hpp>
#include <limits>
#include <span>
#include <string>
#include <vector>

namespace tessera::test {

/// A phantom in memory, or a box of it.
class PhantomChunks final : public ChunkSource {
  public:
    PhantomChunks(const std::string& name, const glm::ivec3& extent, const glm::ivec3& low = glm::ivec3(0),
                  glm::ivec3 size = glm::ivec3(0)) {
        const auto source = makePhantom(name, extent);
        info_ = source->info();
        whole_.resize(cellCount(extent));
        source->readSlices(extent.z, std::as_writable_bytes(std::span(whole_)));
        extent_ = extent;
        low_ = low;
        if (size != glm::ivec3(0)) {
            info_.extentVoxels = size;
            info_.patientFromVoxel[3] += info_.patientFromVoxel * glm::dvec4(glm::dvec3(low), 0);
        }
    }
    const VolumeInfo& info() const override { return info_; }
    void readChunk(const ChunkKey& key, std::span<std::byte> out) const override {
        const glm::ivec3 corner = glm::ivec3(key.i, key.j, key.k) * kChunkExtent;
        std::size_t n = 0;
        for (int z = 0; z < kChunkExtent; ++z)
            for (int y = 0; y < kChunkExtent; ++y)
                for (int x = 0; x < kChunkExtent; ++x) {
                    const glm::ivec3 v = corner + glm::ivec3(x, y, z);
                    const bool in = glm::all(glm::lessThan(v, info_.extentVoxels));
                    const std::int16_t value =
                        in ? whole_[linearIndex(v + low_, extent_)] : std::int16_t{-1024};
                    std::memcpy(out.data() + 2 * n++, &value, 2);
                }
    }

  private:
    VolumeInfo info_;
    std::vector<std::int16_t> whole_;
    glm::ivec3 extent_, low_;
};

/// About normal, standard deviation 1, hashed from a voxel's place.
inline double normalAt(const glm::ivec3& voxel) {
    double sum = 0;
    for (std::uint32_t i = 0; i < 6; ++i) {
        std::uint32_t h = static_cast<std::uint32_t>(voxel.x) * 73856093u ^
                          static_cast<std::uint32_t>(voxel.y) * 19349663u ^
                          static_cast<std::uint32_t>(voxel.z) * 83492791u ^ (i + 1) * 2654435761u;
        h = (h ^ (h >> 15)) * 2246822519u;
        h = (h ^ (h >> 13)) * 3266489917u;
        sum += static_cast<double>(h ^ (h >> 16)) / 4294967296.0 - 0.5;
    }
    return sum * std::sqrt(2.0);
}

/// int16 values of a source and noise.
/// @param lowest  what is below it is clipped to it
class NoisyChunks final : public ChunkSource {
  public:
    NoisyChunks(const ChunkSource& source, double deviation,
                double lowest = std::numeric_limits<std::int16_t>::lowest())
        : source_(source), deviation_(deviation), lowest_(lowest) {}
    const VolumeInfo& info() const override { return source_.info(); }
    void readChunk(const ChunkKey& key, std::span<std::byte> out) const override {
        source_.readChunk(key, out);
        const glm::ivec3 corner = glm::ivec3(key.i, key.j, key.k) * kChunkExtent;
        for (std::size_t i = 0; i < out.size() / 2; ++i) {
            std::int16_t value = 0;
            std::memcpy(&value, out.data() + 2 * i, 2);
            const auto n = static_cast<int>(i);
            const double noisy =
                value + deviation_ * normalAt(corner + glm::ivec3(n % 32, n / 32 % 32, n / 1024));
            value = static_cast<std::int16_t>(std::lround(std::max(noisy, lowest_)));
            std::memcpy(out.data() + 2 * i, &value, 2);
        }
    }

  private:
    const ChunkSource& source_;
    const double deviation_, lowest_;
};

} // namespace tessera::test
