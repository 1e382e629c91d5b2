// bricking/analysis/surface/mesh_parts.h: a mesh that is held whole, its parts (triangles that points join),
// and what they enclose.
#pragma once

#include "bricking/analysis/surface/surface_mesh.h"
#include "core/base/triangle_mesh.h"

#include <cstddef>
#include <cstdint>

namespace tessera {

/// Takes a mesh as it is found; places as numbers of 32 bits.
class HeldSurface final : public MeshSink {
  public:
    /// Reserves memory for so many; the caller has charged heldBytes().
    HeldSurface(std::uint64_t points, std::uint64_t triangles);
    static std::size_t heldBytes(std::uint64_t points, std::uint64_t triangles);
    void point(const glm::dvec3& mm) override { mesh.points.emplace_back(mm); }
    void triangle(const std::array<std::uint32_t, 3>& numbers, const std::array<glm::dvec3, 3>&) override {
        mesh.triangles.emplace_back(numbers[0], numbers[1], numbers[2]);
    }
    TriangleMesh mesh;
};

/// Area and volume of a closed mesh; cavities do not count.
struct MeshMeasures {
    double areaMm2 = 0, volumeMm3 = 0;
};
MeshMeasures measuresOf(const TriangleMesh& mesh);

struct PartsChoice {
    bool largest = false;      // only the part that encloses most
    double leastVolumeMm3 = 0; // only parts that enclose so much
    bool any() const { return largest || leastVolumeMm3 > 0; }
};
struct PartsFound {
    std::uint64_t parts = 0, kept = 0;
};
/// Memory that keepParts() takes besides the mesh.
std::size_t partsBytes(std::uint64_t points);
/// Drops the other parts. A cavity is a part of its own: dropped, it is filled. Points keep their order.
PartsFound keepParts(TriangleMesh& mesh, const PartsChoice& choice);

} // namespace tessera
