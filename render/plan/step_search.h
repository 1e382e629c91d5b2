// render/plan/step_search.h: draws some of a picture's pixels again: before the picture to choose step and
// integrator, afterwards to estimate its error (picture_check.h).
#pragma once

#include "core/image/image.h"
#include "render/contract/ray.h"
#include "render/contract/strides.h"
#include "render/plan/picture_check.h"
#include "render/plan/planner.h"

#include <functional>
#include <optional>

namespace tessera {

/// Draws rays of a plan to their end, as the picture itself is drawn.
using PixelDrawer = std::function<Image(const RayFrame<double>&, const Strides&)>;

class StepSearch {
  public:
    /// The plan outlives it; its step and integrator are those that are chosen.
    StepSearch(Planner& plan, PixelDrawer drawer)
        : plan_(plan), drawer_(std::move(drawer)), grid_(plan.view.imageSize) {}

    /// What a step's error must stay below, over the grid's pixels: CIE L*u*v* at the 99th
    /// percentile, or rms.
    struct Goal {
        enum class Measure { luvP99, rms } measure;
        double limit;
    };
    /// Takes the step and integrator that cost the least of those that reach the goal, and the best that was
    /// found where none does: of 2, 1, 1/2 ... 1/16 voxel, and where half a step is good enough and the whole
    /// is not, of those between that are within kLuvOfLonger too. Returns the error, by the goal's measure.
    double chooseStep(const Goal& goal);
    /// Voxels; none is finer.
    static constexpr double kFinestStep = 1.0 / 16;
    /// L*u*v* at the 99th percentile: what steps may err by of the 3 that can be told apart, so that samples
    /// of pixels, which are apart from them, have as much.
    static constexpr double kLuvOfLonger = 2;
    /// Of the picture that was drawn. The plan fetches exactly afterwards.
    PictureErrors errorsOf(const Image& picture, double brightest);
    /// The same of a picture whose pixels are no rays through their middles: those are drawn again.
    PictureErrors errors(double brightest);

  private:
    Image draw(double stepVoxels);
    PictureErrors errorsOfGrid(const Image& mine, double brightest);

    struct Chosen {
        Integrator integrator;
        double step;
        StepError estimate;
    };
    std::optional<Chosen> chosen_;
    Planner& plan_;
    PixelDrawer drawer_;
    PixelGrid grid_;
};

} // namespace tessera
