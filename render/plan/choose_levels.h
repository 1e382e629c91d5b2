// render/plan/choose_levels.h: the selection for a scene's quality and budgets. It reads statistics, predicts
// errors, and chooses levels (bricking/levels/level_selection.h has the rules).
#pragma once

#include "bricking/levels/level_chooser.h"
#include "bricking/statistics/statistics.h"
#include "bricking/store/store_reader.h"
#include "core/scene/scene.h"
#include "render/plan/drawn_part.h"
#include "render/plan/frame_context.h"
#include "render/residency/pages.h"

#include <memory>
#include <span>

namespace tessera {

struct Layer;        // frame_plan.h
struct SharedVolume; // render/parts/process_group.h

/// The choice of levels. perBrick: by the scene's quality. quick: one coarse level for all bricks, for a fast
/// first picture. finest: the finest levels, in as many passes as the budget needs. Others are for tests and
/// comparisons: the finest single level that fits.
enum class LevelChoice { perBrick, quick, finest, oneForAll, oneForAllNothingCulled };

/// The layers around an empty brick that must be invisible.
inline Culling cullingFor(const Shading& shading) {
    return !shading.on ? Culling::unlit : reachOf(shading.gradient) > 1 ? Culling::smooth : Culling::lit;
}

struct ChosenLevels {
    Selection selection;
    std::size_t atlasPages = 0;   // of the atlas; fewer than the selection's with several passes
    std::size_t unseenBricks = 0; // of the selection's empty ones: see BestLevels, or outside the drawn part
    /// False if errors of levels are not predicted: RAM too small for their statistics, one level for all, or
    /// rays that keep one value.
    bool predicted = false;
    PredictedError error; // if predicted
    /// True if counting visibility and choosing again pays (Planner::chooseByVisibility()).
    std::unique_ptr<LevelChooser> chooser;
    /// Where processes draw the volume together (FrameContext::group). Pages of the atlas are then for the
    /// bricks of this one.
    std::shared_ptr<const SharedVolume> shared;
};

/// Largest number of pages of one segment's neighbourhood. A value needs up to eight bricks. The differences
/// of a gradient reach half a brick further, as do the values at both ends, which are at most half a brick
/// apart. The minimum for an atlas with several passes.
constexpr std::size_t neighbourhoodPages(bool gradients, bool ends) {
    return gradients || ends ? 27 : 8;
}

/// The best selection of so many pages (LevelChooser::best()) and its predicted error. If that error is zero,
/// the selection's finest level is used everywhere where that renders faster: it fits the pages, and its
/// load costs no more than drawing gains. It is never further from the truth. Interactive pictures take the
/// same levels, so they converge to the still.
struct BestLevels {
    Selection selection;
    PredictedError error;
    std::size_t unseenBricks = 0; // of the empty ones: without any ray near them
};
/// Bricks far from all rays of a still need no level of their own: without them, the bricks of a close camera
/// mostly have one level.
enum class Unseen { kept, leftOut };
/// They are kept with occlusion of surfaces, reflections and paths of light, which reach beyond the picture,
/// and with wide gradients.
Unseen unseenBy(const Lighting& lighting, const Shading& shading, bool reflects);
BestLevels bestLevels(const LevelChooser& chooser, std::span<const float> means, std::size_t pages,
                      Visibility visible, Unseen unseen = Unseen::kept);

/// Rays that keep one value use one level for all: the finest that fits and, for planes and means, that a
/// pixel can show.
/// @param part  the drawn part of the volume: bricks outside are left out
/// @param gpuFixed  bytes of gpu for the scene besides its bricks
/// @param ramKept  bytes of ram that must stay free for later allocations
/// Processes that share the volume take levels whose bricks fit into the memory of all of them together, each
/// of which has gpu for those of its part and the bricks around.
/// Throws InputError naming the minimum if gpu cannot hold the scene's minimum memory. Throws it if ram
/// cannot hold the statistics that a scene with an error bound needs.
ChosenLevels chooseLevels(const Scene& scene, const Camera& camera, const DrawnPart& part, const Layer& layer,
                          const TextureLimits& limits, LevelChoice choice, std::size_t gpuFixed,
                          std::size_t ramKept, const FrameContext& context);

} // namespace tessera
