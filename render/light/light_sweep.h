// render/light/light_sweep.h: MapSweep: fills a light map (light_map.h): light crosses the grid slice by
// slice, forwards and back (docs/sampling.md, "Light maps"). In every slice it is a two-stream solution of
// the transfer of light; between slices it spreads sideways by small-angle moments (Fermi and Eyges).
// Sources: Meador, Weaver 1980 (two streams); adding of layers: Grant, Hunt 1969; Eyges 1948.
#pragma once

#include "render/light/light_map.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace tessera {

/// How tissue scatters light: Henyey and Greenstein's phase function.
struct SweptScattering {
    /// Slices are crossed at an angle: scattered light's way is this times as long as theirs (Eddington).
    static constexpr float kObliquity = 1.5f;
    float onwards = 0.5f; // share of a beam's scattered light that goes to the half space before it
    float back = 0.5f;    // the rest
    float turned = 0.5f;  // share of what scatters scattered light that changes its side: (1 - g)/2
    float angle = 1;      // mean square of a scattering's angle, 2 (1 - g), at most 1
    explicit SweptScattering(double g);
};

/// What a slice does to light, of one colour.
struct SweptLayer {
    float through = 1, returned = 0; // shares of scattered light, from either side
    float sent = 0, sentBack = 0;    // of the beam that enters it: leaves as scattered light, ahead and back
};
/// @param depth  optical, from 0 on
/// @param gone   1 - e^-depth
SweptLayer sweptLayer(float depth, float gone, float albedo, const SweptScattering& scattering);

class MapSweep {
  public:
    /// @param g  mean cosine of the phase function, [0,1)
    MapSweep(const LightGrid& grid, double g);
    /// Working memory, at most, of a map of so many rays along a side.
    static std::size_t bytes(int size);

    /// Of each ray once; of different rays by several threads.
    /// @param slices  as many as the grid has
    void setRay(const glm::ivec2& ray, std::span<const LightSlice> slices);
    /// When all rays are set: light crosses so many more slices of the map, of the same grid. Returns true
    /// when it is filled.
    /// @param threads  0: all processors; any number gives the same bits
    bool cross(int slices, int threads, LightMap& map);
    /// The same to the end.
    void run(int threads, LightMap& map) {
        while (!cross(grid_.slices, threads, map))
            ;
    }
    /// After run(): the share of the light that gets to a node unscattered.
    float beam(std::size_t node) const;
    /// After run(): the shares of the light that leave the grid ahead, by the beam and scattered, and that
    /// come back from it, sums over all rays over their number; red, green, blue.
    const glm::dvec3& ahead() const { return ahead_; }
    const glm::dvec3& back() const { return back_; }

  private:
    /// Scattered light at a node, with moments of its angle and of angle and place, in slices.
    struct alignas(32) Ray {
        std::array<float, 3> light{};
        float angle = 0, drift = 0;
        std::array<float, 3> none{};
    };
    using Plane = std::vector<Ray>;
    void spread(const Ray* from, Ray* to, int at, std::size_t pitch, float square) const;
    template <typename Cross> void crossSlice(int slice, int threads, const Cross& cross);
    SweptLayer layerOf(std::size_t node, float gone, std::size_t colour) const;
    void begin();
    void turn(LightMap& map);
    void goOn(int slice, std::size_t at, LightMap& map);
    void goBack(int slice, std::size_t at, LightMap& map);

    LightGrid grid_;
    SweptScattering scattering_;
    std::vector<float> depth_;                        // of slices
    std::vector<std::array<std::uint8_t, 3>> albedo_; // likewise
    std::vector<std::uint16_t> beam_;                 // of planes
    std::vector<std::array<std::uint16_t, 3>>
        mirror_;         // of planes: share of light from behind that comes back
    Plane here_, there_; // of the plane that light has come to; room
    std::vector<float> beamHere_;
    std::vector<glm::vec3> mirrorHere_;
    int crossed_ = 0; // slices, forwards and back
    glm::dvec3 ahead_{0}, back_{0};
};

} // namespace tessera
