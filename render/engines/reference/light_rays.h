// render/engines/reference/light_rays.h: how much light gets to a place, by rays of the reference's own:
// through level 0, by the function's points, in double. Shadows are exp(-integral of extinction) from a place
// to the light or the volume's border; occlusion is equations 6.1, 6.3 and 6.4 of the course notes. Slow, and
// knows nothing of render/light/ but the directions.
#pragma once

#include "render/contract/lattice.h"
#include "render/contract/optics.h"
#include "render/engines/reference/cells_on_ray.h"
#include "render/engines/reference/cubic.h"
#include "render/engines/reference/reference.h"
#include "render/engines/reference/stored_function.h"

#include <array>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <vector>

namespace tessera {

/// Shares of light by channel (LightingNumbers): occlusion first, then every light that casts a shadow.
using LightShares = std::array<double, leaf::kMostLightChannels>;

/// Where the light of a scene comes from, patient space; the same for all of its rays.
class LightSources {
  public:
    explicit LightSources(const ReferenceInput& input);

    static constexpr int kPlacesOfSoftLight = 8;
    static constexpr double kOffsetVoxels = 1.5; // towards a light, of where rays of shadow start

    struct Caster {
        bool isPoint = false;
        glm::dvec3 middle{0};           // unit, towards the light; or a place, mm
        std::vector<glm::dvec3> places; // over its disk, the same; one alone: the middle
    };
    bool hasOcclusion = false;
    Occlusion occlusion;
    std::vector<glm::dvec3> directions; // of occlusion
    std::vector<Caster> casters;
    double offsetMm = 0;
};

/// One thread's. All that it is given outlives it.
class LightRays {
  public:
    /// @param emptyCells  of 8^3 voxels, passed in one stride; may be empty
    /// @param panels  that a smooth piece of a ray starts with
    LightRays(const VolumeInfo& info, const StoredFunction& function, const LightSources& sources,
              const std::vector<bool>& emptyCells, LatticeReader& samples, int panels);

    /// @param place  voxels
    LightShares at(const glm::dvec3& place);
    int channels() const { return channels_; }

    /// Share of the light that gets to a place, mm, from so far away. @param direction  unit, towards it
    double shadow(const glm::dvec3& place, const glm::dvec3& direction, double mm);
    /// Equation 6.1 for one direction.
    double openness(const glm::dvec3& place, const glm::dvec3& direction);

    /// Below this share of light the rest of a ray is dark.
    static constexpr double kDark = 1e-6;

  private:
    struct Walk {
        double left = 1; // of the light
        double seen = 0; // its integral over the ray, mm
    };
    template <bool withSeen> Walk walk(const glm::dvec3& place, const glm::dvec3& direction, double mm);
    template <bool withSeen> void throughCell(const ReferenceRay& ray, double ta, double tb, Walk& walk);
    template <bool withSeen>
    void throughPiece(const Cubic& cubic, const FunctionPiece& function, double u0, double u1, double length,
                      Walk& walk, int halvings);

    const VolumeInfo& info_;
    const StoredFunction& function_;
    const LightSources& sources_;
    const std::vector<bool>& emptyCells_;
    LatticeReader& samples_;
    glm::ivec3 cells_;
    int panels_, channels_;
    glm::dmat4 toPatient_, toVoxels_;
    std::vector<double> cuts_;
};

} // namespace tessera
