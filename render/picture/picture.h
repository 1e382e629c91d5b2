// render/picture/picture.h: the way from a plan to a picture, the same for every engine and for all that
// measures one. Bricks are loaded, measured visibility may change the levels once, and rays are drawn to
// their end.
#pragma once

#include "core/base/budget.h"
#include "core/base/work.h"
#include "core/image/image.h"
#include "render/engine.h"
#include "render/plan/frame_plan.h"
#include "render/plan/planner.h"
#include "render/plan/step_search.h"

#include <functional>
#include <optional>

namespace tessera {

/// Opens the plan's volume on the engine and loads its bricks. It loads all of them or, if rays will wait for
/// them, none. If the plan asks for it, visibility in a picture of these bricks is counted first, and levels
/// are chosen again. Returns true if rays will wait: bricks then come in several passes.
/// @param kept  the engine holds this volume still, opened for the same plan as before; bricks that keep
///     their level stay in place if there are pages enough
/// @param pages  to open the volume with, at least the plan's; 0: the plan's
bool loadBricks(Engine& engine, Planner& plan, MemoryBudget& gpu, Work& work, bool kept = false,
                std::size_t pages = 0);

/// Draws all rays to their end, bringing the bricks that they wait for. Returns in how many passes.
int drawToTheEnd(RayCaster& caster, Engine& engine, const FramePlan& plan, const Slicing& slicing,
                 Work& work);

/// The same, but stops before bricks take more bytes than that, all of work together: false then.
bool drawWithin(RayCaster& caster, Engine& engine, const FramePlan& plan, const Slicing& slicing,
                std::uint64_t mostBytes, Work& work);

/// The rays of the plan as it is.
Rays raysOf(const FramePlan& plan);
/// The same with another step, in voxels.
Rays raysOf(const FramePlan& plan, double stepVoxels);

// The step of rays where a pixel shows the mean of several, eight at least. Their phases differ
// (RayFrame::phased), so one ray takes samples between those of the others. Their mean then errs far less
// than one of them.

/// The longest step, up to eight times the plan's, at which means over eight rays of a pixel are within the
/// limit, and within StepSearch::kLuvOfLonger; voxels. None where the plan's own is as good: where none is
/// within it, and in pictures so small that the search would cost more. None too where rays have no phases:
/// integrators that take ends, surfaces, which no step moves, and cuts.
/// @param rms   linear light, over up to 24 x 24 of the picture's pixels, against the plan's step with phases
/// @param draw  rays to their end, as the picture's are
std::optional<double> stepOfMeans(const FramePlan& plan, double rms,
                                  const std::function<Image(const Rays&)>& draw);

} // namespace tessera
