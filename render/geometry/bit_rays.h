// render/geometry/bit_rays.h: BitRays: how far rays of light get before voxelised meshes
// (docs/sampling.md, "Voxelised meshes"; Papaioannou, Menexi and Papadopoulos 2010, 5).
#pragma once

#include "render/geometry/mesh_bits.h"

#include <cstdint>
#include <glm/mat3x3.hpp>

namespace tessera {

class BitRays {
  public:
    static constexpr double kStep = 0.5; // voxels
    /// From this height above the surface on which a ray begins a place may be inside, voxels.
    static constexpr double kGuard = 0.5;

    /// @param bits  with distances; outlive this
    /// @param threshold  V from which on a place is inside
    BitRays(const MeshBits& bits, double threshold);

    /// How far from a place on a mesh rays begin, mm.
    /// @param cosine  of the direction with the surface's normal; above 0
    double guardedStart(double cosine) const { return kGuard * bits_.grid().edgeMm / cosine; }

    /// The distance at which a ray ends, or `mostMm`, mm. Where meshes are translucent it ends by chance.
    /// @param place  patient space, mm; direction: unit
    /// @param fromMm  where it begins
    /// @param key  of the ray: equal keys give equal results
    /// @param cosine  where the place is on a mesh: with its normal. No plane shades itself then. Else 0
    double reach(const glm::dvec3& place, const glm::dvec3& direction, double fromMm, double mostMm,
                 std::uint64_t key, double cosine = 0) const;

  private:
    const MeshBits& bits_;
    glm::dmat3 turn_;
    double threshold_;
};

/// Mixes all bits (the finaliser of SplitMix64).
constexpr std::uint64_t mixedBits(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15ULL;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
    return x ^ (x >> 31);
}
/// In [0,1).
constexpr double unitFraction(std::uint64_t bits) {
    return static_cast<double>(bits >> 11) * 0x1p-53;
}

} // namespace tessera
