// render/visibility_pass.h: what of each brick the camera sees past those before it, counted by a small march
// over the bricks that are resident: the feedback for the next choice of levels (bricking/visibility.h).
#pragma once

#include "bricking/visibility.h"
#include "core/budget.h"
#include "core/camera.h"
#include "render/field_binding.h"
#include "render/march.h"

#include <optional>
#include <vector>

namespace tessera {

/// The rays of the pass and their strides.
struct VisibilityRays {
    RayFrame<double> frame;
    Strides strides;
};
/// @param strides  those of the scene's own march
VisibilityRays visibilityRays(const Camera& camera, const VolumeInfo& info, const glm::ivec2& imageSize,
                              const Strides& strides);

/// A picture of a quarter of the pixels along each axis, in long segments, unlit, without leaps and without
/// an early end: so that every ray counts in every brick that it crosses.
class VisibilityPass {
  public:
    /// @param features  of the scene's own march
    VisibilityPass(std::uint32_t features, const VolumeInfo& info, Ledger& gpu);
    /// Per brick, [z][y][x].
    std::vector<SeenBrick> count(const VisibilityRays& rays, const FieldSource& source, const Optics& optics,
                                 Work& work);
    /// The same in parts: what source reads must not change between them. True when all is counted.
    void begin(const VisibilityRays& rays, const Optics& optics);
    bool countUntil(const FieldSource& source, const MarchSlicing& slicing, March::Clock::time_point deadline,
                    Work& work);
    std::vector<SeenBrick> seen() const { return march_->seen(); }
    /// GPU bytes, the transfer function's table not included: the scene's own march is made later.
    static std::size_t bytes(const glm::ivec2& imageSize, const glm::ivec3& bricks);

  private:
    std::uint32_t features_;
    const VolumeInfo& info_;
    Ledger& gpu_;
    std::optional<March> march_; // made by the first count
};

} // namespace tessera
