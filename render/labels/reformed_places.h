// render/labels/reformed_places.h: where the pixels of a reformation lie, in a volume's voxels.
#pragma once

#include "core/base/volume.h"
#include "core/scene/reformation.h"
#include "render/labels/plane_places.h"

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>

namespace tessera {

/// Between two rows places are those of a straight line from one to the other. Of a straight line, or a
/// cross-section, they are a slice's.
class ReformedPlaces : public SurfacePlaces {
  public:
    /// @param picture  outlives this
    ReformedPlaces(const Reformation& picture, const VolumeInfo& info);
    /// None where rows cross one another.
    std::optional<glm::dvec3> at(const glm::dvec2& pixel) const override;

  private:
    const Reformation& picture_;
    glm::dmat4 voxelFromPatient_;
};

} // namespace tessera
