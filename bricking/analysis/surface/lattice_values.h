// bricking/analysis/surface/lattice_values.h: LatticeValues: the field of a volume minus a value, at the
// places of a lattice.
#pragma once

#include "bricking/analysis/surface/surface_lattice.h"
#include "bricking/cache/brick_cache.h"

#include <array>
#include <cstddef>
#include <glm/vec3.hpp>
#include <vector>

namespace tessera {

class LatticeValues {
  public:
    static constexpr double kOutside = -1e150; // its square is far below the largest double
    /// Both outlive it.
    LatticeValues(BrickCache& cache, const VolumeInfo& info, const SurfaceLattice& lattice, double value)
        : cache_(cache), info_(info), lattice_(lattice), value_(value) {}

    /// Takes the field at planes [low, high] of each axis, [z][y][x].
    void read(const glm::ivec3& low, const glm::ivec3& high, std::vector<double>& out);
    /// Of a stored value: rising or falling with it, never both.
    double of(double stored) const { return info_.rescaleSlope * stored + info_.rescaleIntercept - value_; }

  private:
    const std::byte* chunkOf(const glm::ivec3& chunk);
    void readSamples(const glm::ivec3& low, const glm::ivec3& high);

    BrickCache& cache_;
    const VolumeInfo& info_;
    const SurfaceLattice& lattice_;
    double value_;
    struct Held {
        glm::ivec3 chunk{-1};
        ChunkPointer values;
    };
    std::array<Held, 8> held_; // by the low bits of their places: neighbours never evict each other
    std::vector<double> samples_;
};

} // namespace tessera
