// render/labels/plane_places.h: where the pixels of a picture meet a slice's plane, or another surface, in a
// volume's voxels.
#pragma once

#include "core/base/volume.h"
#include "core/scene/camera.h"
#include "core/scene/mode.h"

#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>

namespace tessera {

/// From a picture to level-0 voxels. Read by several threads.
class SurfacePlaces {
  public:
    SurfacePlaces() = default;
    SurfacePlaces(const SurfacePlaces&) = default;
    SurfacePlaces& operator=(const SurfacePlaces&) = default;
    virtual ~SurfacePlaces() = default;

    glm::ivec2 size{0}; // of the picture
    bool isMet = true;  // the surface, anywhere

    /// @param pixel  (0.5, 0.5) is the middle of the first; also beside the picture, for outlines
    /// None where the pixel shows no place.
    virtual std::optional<glm::dvec3> at(const glm::dvec2& pixel) const = 0;
    /// The shortest way on the surface that a pixel is wide or high, level-0 voxels: of the picture's middle
    /// and corners.
    double voxelsPerPixel() const;
};

/// A projective map.
struct PlanePlaces : SurfacePlaces {
    glm::dmat3 toPlace{0};   // of (x, y, 1), pixels; (0.5, 0.5) is the middle of the first: w times the place
    glm::dvec3 toW{0, 0, 1}; // of the same: w, positive where the plane is met
    bool perspective = false; // w is not 1

    /// None where the ray does not meet the plane.
    std::optional<glm::dvec3> at(const glm::dvec2& pixel) const override;
};

/// Of a slab its middle plane.
PlanePlaces planePlaces(const Camera& camera, const SlicePlane& slice, const VolumeInfo& info,
                        const glm::ivec2& imageSize);
/// Of a plane seen along its normal, with its point in the picture's middle.
PlanePlaces planePlaces(const SlicePose& plane, double mmPerPixel, const VolumeInfo& info,
                        const glm::ivec2& imageSize);

} // namespace tessera
