// render/light/light_map.h: LightMap: a grid in the view of a light that keeps the light which tissue
// scatters, on its way through the volume (course notes 10; docs/sampling.md, "Light maps"). How it is
// filled: light_sweep.h. Knows no volume.
#pragma once

#include "render/light/shadow_map.h"

#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace tessera {

/// Places of a grid: rays of a square view, crossed by planes at right angles to it, or by shells around its
/// eye. Between two of these lies a slice.
struct LightGrid {
    int size = 1;             // rays along either side
    int slices = 1;           // at most as many
    double nearMm = 0;        // of the first plane, along rays from where they start
    double sliceMm = 1;       // thickness of a slice
    double rayMm = 1;         // distance of neighbouring rays; perspective: at 1 mm from the eye
    bool perspective = false; // shells, not planes
    bool oneOfSides =
        false; // of six views from one place: what leaves it sideways comes back, as from the next

    /// Distance of neighbouring rays at a plane, mm.
    double rayMmAt(int plane) const { return perspective ? rayMm * (nearMm + plane * sliceMm) : rayMm; }
    std::size_t nodesOfPlane() const {
        return static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
    }
    std::size_t nodes() const { return nodesOfPlane() * (static_cast<std::size_t>(slices) + 1); }
    /// Of a view of such a size between two distances: a slice is as thick as rays are apart in its middle,
    /// or thicker where there are as many slices as rays along a side.
    static LightGrid between(double nearMm, double farMm, double rayMm, int size, bool perspective);
};

/// What lies in a slice along a ray.
struct LightSlice {
    float depth = 0;     // optical
    glm::vec3 albedo{0}; // share of light that a scattering leaves, [0,1]
};
/// The optical depth at which a segment, or a surface, lets no light through.
constexpr float kOpaqueDepth = 40;

/// Adds tissue to the slices of a ray: an even depth between two distances.
/// @param slices  all of the grid's; albedos are sums by depth until finishSlices()
void addToSlices(const LightGrid& grid, float fromMm, float toMm, float depth, const glm::vec3& albedo,
                 std::span<LightSlice> slices);
/// Makes albedos means.
/// @param endMm  where a ray was left, in the dark: slices from there on are as the one before; a negative
/// number: it came through
void finishSlices(const LightGrid& grid, float endMm, std::span<LightSlice> slices);

class LightMap {
  public:
    explicit LightMap(const LightGrid& grid) : grid_(grid), shares_(3 * grid.nodes()) {}
    const LightGrid& grid() const { return grid_; }
    std::size_t bytes() const { return shares_.size() * sizeof(std::uint16_t); }
    /// At most, of a map of so many rays along a side.
    static std::size_t bytes(int size);

    /// Scattered light relative to what would arrive with nothing in the way, red, green, blue, [0,4);
    /// between nodes by trilinear interpolation. Beyond the first and the last plane it is that of those, and
    /// beyond the outermost rays theirs: samples of coarse levels may lie there.
    /// @param at  rays from the map's corner, the first one's centre at (0.5,0.5)
    /// @param mm  along the ray
    glm::vec3 at(const glm::vec2& at, float mm) const;

    /// Of a node: three texels of light, leaf::kLightOne each of full light.
    std::uint16_t* node(std::size_t n) { return shares_.data() + 3 * n; }
    const std::uint16_t* node(std::size_t n) const { return shares_.data() + 3 * n; }

  private:
    LightGrid grid_;
    std::vector<std::uint16_t> shares_; // plane by plane, row by row
};

} // namespace tessera
