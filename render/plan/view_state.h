// render/plan/view_state.h: the state of the view: camera, picture, step, and revisions for data derived from
// it.
#pragma once

#include "core/base/budget.h"
#include "core/scene/camera.h"
#include "core/scene/scene.h"
#include "render/contract/ray.h"
#include "render/light/shadow_maps.h" // ShadowQuality
#include "render/plan/drawn_part.h"

#include <cstdint>
#include <glm/vec2.hpp>
#include <vector>

namespace tessera {

struct ViewState {
    Camera camera;
    glm::ivec2 imageSize{0};
    Quality quality; // current step, sampling and fetch; the requested integrator
    RayFrame<double> frame;
    DrawnPart part;    // of the volume
    Lighting lighting; // the scene's, as are the next two
    Shading shading;
    std::vector<Isosurface> surfaces;
    ShadowQuality shadowQuality;
    Charge imageCharge; // pictures and ray states, in RAM

    /// Sets the rays for camera, picture and step. Planner::aim() also places lights.
    void aim(const VolumeInfo& info) {
        frame = rayFrame(camera, info, imageSize, quality.stepVoxels);
        part.clip(frame);
    }
};

/// The parts that can change between two pictures.
enum Change : std::uint32_t {
    kCameraChanged = 1u << 0,
    kFunctionChanged = 1u << 1,
    kLevelsChanged = 1u << 2,     // of bricks
    kEmptySpaceChanged = 1u << 3, // its map
    kLightChanged = 1u << 4,      // of voxels
};

/// Changes since the last check: each consumer of a scene keeps one.
class Changes {
  public:
    explicit Changes(std::uint32_t changes = 0) : bits_(changes) {}
    void add(std::uint32_t changes) { bits_ |= changes; }
    bool any(std::uint32_t changes) const { return (bits_ & changes) != 0; }
    bool any() const { return bits_ != 0; }
    /// Returns true if there were any of these, and clears them.
    bool take(std::uint32_t changes) {
        const bool were = any(changes);
        bits_ &= ~changes;
        return were;
    }

  private:
    std::uint32_t bits_;
};

} // namespace tessera
