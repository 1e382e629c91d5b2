// render/backends/reference/light_rays.h: the light that reaches a point, by rays of the reference's own:
// through level 0, by the function's points, in double. Shadows are exp(-integral of extinction) from a point
// to the light or the volume's border. Occlusion is equations 6.1, 6.3 and 6.4 of the course notes. It is
// slow, and shares only the directions with render/light/.
#pragma once

#include "render/backends/reference/cell_gradients.h"
#include "render/backends/reference/cells_on_ray.h"
#include "render/backends/reference/labels_along_ray.h"
#include "render/backends/reference/left_by_others.h"
#include "render/backends/reference/light_sources.h"
#include "render/backends/reference/reference.h"
#include "render/backends/reference/stored_function.h"
#include "render/contract/lattice.h"
#include "render/contract/optics.h"

#include <array>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <utility>
#include <vector>

namespace tessera {

/// Shares of light by channel (LightingNumbers): occlusion first, then every light that casts a shadow.
using LightShares = std::array<double, leaf::kMostLightChannels>;

/// The contribution of one occlusion ray: the two parts of equation 6.5.
struct GatheredLight {
    double open = 0;    // of ambient light
    glm::dvec3 sent{0}; // from emissive tissue along the ray
};

/// The extinction of light rays: the function's, and behind each isosurface one that transmits over a voxel's
/// length as much light as the surface. Over stored values.
class Obstacles {
  public:
    Obstacles(const StoredFunction& function, const VolumeInfo& info);

    /// Kinks of extinction, ascending.
    const std::vector<double>& kinks() const { return kinks_; }
    bool emptyOver(double lo, double hi) const;
    glm::dvec3 emission(double stored) const { return function_.emission(stored); }
    FunctionPiece pieceAround(double stored) const { return function_.pieceAround(stored); }
    /// Extinction of the surfaces in front of a value, 1/mm.
    double behindSurfaces(double stored) const;

  private:
    const StoredFunction& function_;
    std::vector<double> kinks_;
    std::vector<double> ofSurfaces_; // 1/mm
};

/// For one thread. All inputs outlive it.
class LightRays {
  public:
    /// @param emptyCells  without extinction: passed in one stride
    /// @param labels  at the finest level; null: there are none
    /// @param initial panels of a smooth piece of a ray
    LightRays(const VolumeInfo& info, const Optics& optics, const Obstacles& obstacles,
              const LightSources& sources, const EmptyCells& emptyCells, LatticeReader& samples,
              LabelField* labels, int panels);

    /// Volumes whose tissue takes this one's ambient light, too. They outlive this, and are not it.
    void setOthers(std::vector<LightRays*> others);
    /// @param place  voxels
    LightShares at(const glm::dvec3& place);
    /// Multiplies the shares of lights by what this volume leaves of them, at a place of another.
    /// @param place  patient space
    /// @param channel  of the first light that casts a shadow, in shares
    void shade(const glm::dvec3& place, std::size_t channel, LightShares& shares);
    std::size_t firstShadowChannel() const {
        return sources_.hasOcclusion ? static_cast<std::size_t>(sources_.ambientChannels) : 0;
    }
    int channels() const { return channels_; }

    /// Share of the light that reaches a point from a distance, mm.
    /// @param direction  unit, towards it
    double shadow(const glm::dvec3& place, const glm::dvec3& direction, double mm);
    /// Equation 6.1 for one direction. By the scene's method only the light left at the ray's end counts, and
    /// only extinction that does not fall along the ray.
    double openness(const glm::dvec3& place, const glm::dvec3& direction) {
        return gathered(place, direction).open;
    }
    GatheredLight gathered(const glm::dvec3& place, const glm::dvec3& direction);

    struct Reached {
        double mm = -1;  // below 0: nowhere
        double left = 1; // share of light at the end, where it is nowhere
    };
    /// Where the light left on a way falls below a share: the optical depth is inverted, not stepped through.
    /// @param from  voxels
    /// @param perMm  voxels
    Reached reach(const glm::dvec3& from, const glm::dvec3& perMm, double mm, double share);

    /// Share of light below which the rest of a ray is dark.
    static constexpr double kDark = 1e-6;

  private:
    void refuseHemisphere(const char* beside) const;
    SurfaceAround surfaceAt(const glm::dvec3& voxel);
    double leftOf(const LightSources::Caster& light, const glm::dvec3& place);
    /// What a walk is for: the light left at its end; that along it, too; or where little is left.
    enum class Ask { left, seen, place };
    struct Walk {
        double left = 1;      // of the light
        double seen = 0;      // its integral over the ray, mm
        glm::dvec3 sent{0};   // the same, of emitted light
        double until = kDark; // the walk ends below it
        double reached = -1;  // mm to there
        bool ends() const { return left < until; }
    };
    /// A part of a ray between two planes of sample centres.
    struct CellOnWay {
        Cubic cubic;                      // stored value
        double begins, length;            // mm
        const GradientAlongRay* gradient; // none: no gradient opacity
        const LabelsAlongRay* labels;     // none: no labels
        /// Of the function's extinction, and of all.
        double total(double u, double extinction) const {
            const double graded = gradient ? extinction * gradient->factor(u) : extinction;
            return labels ? labels->function(u, graded) + labels->medium(u) : graded;
        }
    };
    /// The integral of the light that others leave, mm.
    double clear(double from, double to) const { return past_ ? past_->between(from, to) : to - from; }
    Walk pastMeshes(const glm::dvec3& first, const glm::dvec3& direction, double mm);
    template <Ask ask> Walk walk(const glm::dvec3& place, const glm::dvec3& direction, double mm);
    template <Ask ask> void along(const ReferenceRay& ray, double mm, Walk& walk);
    template <Ask ask> void throughCell(const ReferenceRay& ray, double ta, double tb, Walk& walk);
    template <Ask ask>
    void throughPiece(const CellOnWay& cell, const FunctionPiece& function, double behind, double u0,
                      double u1, Walk& walk, int halvings);

    const VolumeInfo& info_;
    const Optics& optics_;
    const Obstacles& obstacles_;
    const LightSources& sources_;
    const EmptyCells& emptyCells_;
    LatticeReader& samples_;
    LabelField* labels_;
    int panels_, channels_;
    bool rejects_, gathersEmission_;
    glm::dmat4 toPatient_, toVoxels_;
    std::vector<double> cuts_;
    std::vector<LightRays*> others_;
    const LeftByOthers* past_ = nullptr; // of the ray that is gathered; none: there are no others
};

} // namespace tessera
