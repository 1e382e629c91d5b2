// render/picture/step_of_means.h: the step of rays where a pixel shows the mean of several, eight at least.
// Their phases differ (RayFrame::phased), so one ray takes samples between those of the others. Their mean
// then errs far less than one of them.
#pragma once

#include "core/image/image.h"
#include "render/engine.h"
#include "render/plan/frame_plan.h"

#include <functional>
#include <optional>

namespace tessera {

/// The longest step, up to eight times the plan's, at which means over eight rays of a pixel are within the
/// limit, and within StepSearch::kLuvOfLonger; voxels. None where the plan's own is as good: where none is
/// within it, and in pictures so small that the search would cost more. None too where rays have no phases:
/// integrators that take ends, surfaces, which no step moves, and cuts.
/// @param rms   linear light, over up to 24 x 24 of the picture's pixels, against the plan's step with phases
/// @param draw  rays to their end, as the picture's are
std::optional<double> stepOfMeans(const FramePlan& plan, double rms,
                                  const std::function<Image(const Rays&)>& draw);

} // namespace tessera
