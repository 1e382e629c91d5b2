// render/backends/gpu/visibility_pass.h: the visibility of each brick past those in front of it, counted by a
// small ray caster over the resident bricks. It is the feedback for the next choice of levels
// (bricking/levels/visibility.h).
#pragma once

#include "bricking/levels/visibility.h"
#include "core/base/budget.h"
#include "render/backends/gpu/bindings.h"
#include "render/backends/gpu/march.h"
#include "render/plan/visibility_rays.h"

#include <optional>
#include <vector>

namespace tessera {

/// A picture of a quarter of the pixels along each axis, in long segments, unlit, without leaps and without
/// an early end. So every ray counts in every brick that it crosses.
class VisibilityPass {
  public:
    /// @param features  of the scene's own ray caster
    VisibilityPass(std::uint32_t features, const VolumeInfo& info, MemoryBudget& gpu);
    /// Per brick, [z][y][x].
    std::vector<SeenBrick> count(const VisibilityRays& rays, const FieldSource& source, const Optics& optics,
                                 Work& work);
    /// The same in parts: the data that source reads must not change between them. True when all is counted.
    void begin(const VisibilityRays& rays, const Optics& optics);
    bool countUntil(const FieldSource& source, const Slicing& slicing, March::Clock::time_point deadline,
                    Work& work);
    std::vector<SeenBrick> seen() const { return march_->seen(); }

  private:
    std::uint32_t features_;
    const VolumeInfo& info_;
    MemoryBudget& gpu_;
    std::optional<March> march_; // made by the first count
};

} // namespace tessera
