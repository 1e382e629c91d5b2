// render/backends/splat/splat_points.h: points of no lattice among a volume's slices (docs/sampling.md,
// "Splats"): each a Gaussian around its place, in the sheet that its middle lies in.
#pragma once

#include "core/base/budget.h"
#include "render/backends/splat/splat_filter.h"
#include "render/backends/splat/splat_projection.h"
#include "render/backends/splat/splat_samples.h"
#include "render/backends/splat/splat_settings.h"
#include "render/plan/frame_plan.h"

#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace tessera {

/// How the points of a mesh look.
struct PointLook {
    glm::mat3 kernel{0};  // as SplatView::kernel()
    float nearest = 0;    // depth before which they are left out, mm
    float mass = 0;       // as ShownSample::mass
    FilterDepths filters; // of each point by itself
    glm::vec3 colour{0};  // linear light, unlit
};

struct ShownPoint {
    glm::vec3 at{0}; // in the picture's axes, mm
    std::uint32_t look = 0;
    std::int32_t sheet = 0;
};

class SplatPoints {
  public:
    /// Takes the points of the plan's meshes, all of which are points (checked), by sheet and then in the
    /// order of the scene and its files.
    /// @param step  voxels of a sheet
    SplatPoints(const FramePlan& plan, const SplatView& view, const SplatSettings& settings,
                const SliceOrder& order, int step, MemoryBudget& budget);

    std::span<const PointLook> looks() const { return looks_; }
    /// Those of the first sheet that is left, up to one that is drawn next; empty: there are none.
    std::span<const ShownPoint> next(int sheet);
    /// The same of all that are left.
    std::span<const ShownPoint> next();

  private:
    bool fromEnd_;
    Charge charge_;
    std::vector<PointLook> looks_;
    std::vector<ShownPoint> points_;
    std::size_t taken_ = 0;
};

} // namespace tessera
