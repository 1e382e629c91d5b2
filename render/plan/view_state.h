// render/plan/view_state.h: the state of the view: camera, picture, step, and the changes since something was
// last made from it.
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
    Quality quality; // step, sampling and fetch as they are; integrator as it is asked for
    RayFrame<double> frame;
    DrawnPart part;    // of the volume
    Lighting lighting; // the scene's, as the two after it
    Shading shading;
    std::vector<Isosurface> surfaces;
    ShadowQuality shadowQuality;
    Charge imageCharge; // pictures and what an engine keeps of every ray, in RAM

    /// The rays of camera, picture and step as they are. Planner::aim() also places lights.
    void aim(const VolumeInfo& info) {
        frame = rayFrame(camera, info, imageSize, quality.stepVoxels);
        part.clip(frame);
    }
};

/// What can change between two pictures.
enum Change : std::uint32_t {
    kCameraChanged = 1u << 0,
    kFunctionChanged = 1u << 1,
    kLevelsChanged = 1u << 2,     // of bricks
    kEmptySpaceChanged = 1u << 3, // its map
    kLightChanged = 1u << 4,      // of voxels
};

/// What has changed since somebody last looked: everybody who makes something from a scene keeps one.
class Changes {
  public:
    explicit Changes(std::uint32_t changes = 0) : bits_(changes) {}
    void add(std::uint32_t changes) { bits_ |= changes; }
    bool any(std::uint32_t changes) const { return (bits_ & changes) != 0; }
    bool any() const { return bits_ != 0; }
    /// Whether there were any of these; there are none from now on.
    bool take(std::uint32_t changes) {
        const bool were = any(changes);
        bits_ &= ~changes;
        return were;
    }

  private:
    std::uint32_t bits_;
};

} // namespace tessera
