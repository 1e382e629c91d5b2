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

/// Draws rays of a plan completely, like the picture itself.
using PixelDrawer = std::function<Image(const RayFrame<double>&, const Strides&)>;

class StepSearch {
  public:
    /// The plan outlives it, and gets the chosen step and integrator.
    StepSearch(Planner& plan, PixelDrawer drawer)
        : plan_(plan), drawer_(std::move(drawer)), grid_(plan.view.imageSize) {}

    /// Bound of a step's error over the grid's pixels: CIE L*u*v* at the 99th percentile, or rms.
    struct Goal {
        enum class Measure { luvP99, rms } measure;
        double limit;
    };
    /// Chooses the cheapest step and integrator that reach the goal, or the best found if none does. Steps
    /// are 2, 1, 1/2 ... 1/16 voxel. If half a step is good enough and the whole is not, steps between are
    /// tried, which must be within kLuvOfLonger too. Returns the error, by the goal's measure.
    double chooseStep(const Goal& goal);
    /// The finest step, voxels.
    static constexpr double kFinestStep = 1.0 / 16;
    /// L*u*v* at the 99th percentile: the share of steps in a visible difference of 3, so that the
    /// independent error of pixel samples has an equal share.
    static constexpr double kLuvOfLonger = 2;
    /// Estimates errors of the drawn picture. The plan fetches exactly afterwards.
    PictureErrors errorsOf(const Image& picture, double brightest);
    /// The same for a picture whose pixels are not rays through their centres: these are drawn again.
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
