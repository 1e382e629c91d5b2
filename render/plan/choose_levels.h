// render/plan/choose_levels.h: the selection that a scene's quality and budgets ask for. Statistics are read,
// errors predicted, levels chosen (bricking/levels/level_selection.h has the rules).
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

/// The way levels are chosen. perBrick: as the scene's quality says. quick: one for all bricks, so coarse
/// that a first picture is there at once. finest: the finest there is, in as many passes as the budget needs.
/// The others are for tests and comparisons: the finest one for all that fits.
enum class LevelChoice { perBrick, quick, finest, oneForAll, oneForAllNothingCulled };

/// What must show nothing around a brick that is left out.
inline Culling cullingFor(const Shading& shading) {
    return shading.on ? Culling::lit : Culling::unlit;
}

struct ChosenLevels {
    Selection selection;
    std::size_t atlasPages = 0; // of the atlas; fewer than the selection's where it takes several passes
    std::size_t unseenBricks =
        0; // of the selection's empty ones: BestLevels, or not of the part that is drawn
    /// False: no statistics of errors in this budget of RAM, one level for all, or rays that keep one value,
    /// whose errors by level nobody predicts.
    bool predicted = false;
    PredictedError error; // where predicted
    /// Where it pays to count what is seen and to choose again (Planner::chooseByVisibility()).
    std::unique_ptr<LevelChooser> chooser;
};

/// Pages that the neighbourhood of one segment can take. A value takes eight bricks. The differences of a
/// gradient take those half a brick further, and so do the values at its two ends, which are at most half a
/// brick apart. No atlas of several passes may have fewer.
constexpr std::size_t neighbourhoodPages(bool gradients, bool ends) {
    return gradients || ends ? 27 : 8;
}

/// The best selection of so many pages (LevelChooser::best()) and its predicted error. If that error is zero,
/// the selection's finest level is used everywhere where that renders faster: it fits the pages, and its
/// load costs no more than drawing gains. It is never further from the truth. Pictures that follow one
/// another take the same levels, so they come to the still's picture.
struct BestLevels {
    Selection selection;
    PredictedError error;
    std::size_t unseenBricks = 0; // of the empty ones: left out because no ray comes near them
};
/// Bricks that no ray of a still comes near need no level of their own: with them left out, a close camera's
/// bricks are mostly of one level.
enum class Unseen { kept, leftOut };
/// Kept where surfaces take occlusion: their light comes from beside the picture.
Unseen unseenBy(const Lighting& lighting);
BestLevels bestLevels(const LevelChooser& chooser, std::span<const float> means, std::size_t pages,
                      Visibility visible, Unseen unseen = Unseen::kept);

/// Rays that keep one value take one level for all: the finest that fits and, of planes and means, that a
/// pixel can show.
/// @param part      what is drawn of the volume: bricks outside are left out
/// @param gpuFixed  bytes that the scene takes of gpu besides its bricks
/// @param ramKept   bytes of ram that must stay free for what comes after
/// Throws InputError naming the floor when gpu cannot hold what the scene needs at least, and when ram cannot
/// hold the statistics that a scene with an error to stay below needs.
ChosenLevels chooseLevels(const Scene& scene, const Camera& camera, const DrawnPart& part,
                          const Statistics& statistics, const TransferTable& table, const StoreReader& store,
                          const TextureLimits& limits, LevelChoice choice, std::size_t gpuFixed,
                          std::size_t ramKept, const FrameContext& context);

} // namespace tessera
