// render/engines/gpu/check_march.h: a picture's own march, used to draw some of its pixels again: to choose
// step and integrator before it is drawn, and to say how wrong it is afterwards (picture_check.h).
#pragma once

#include "core/image.h"
#include "render/engines/gpu/march.h"
#include "render/plan/picture_check.h"
#include "render/plan/prepare.h"

#include <functional>

namespace tessera {

class CheckMarch {
  public:
    /// @param run  marches all rays to their end, bringing the bricks that they wait for
    CheckMarch(March& march, std::uint32_t features, PreparedScene& scene,
               std::function<void(March&, Work&)> run, Ledger& ram)
        : march_(march), features_(features), scene_(scene), run_(std::move(run)), ram_(ram),
          grid_(scene.imageSize) {}

    /// What a step's error must stay below, over the grid's pixels: CIE L*u*v* at the 99th percentile, or
    /// rms.
    struct Goal {
        enum class Measure { luvP99, rms } measure;
        double limit;
    };
    /// Takes the step and integrator that cost the least of those that reach the goal, and the best that was
    /// found where none does. The march is ready for the picture then. Returns the error, by the goal's
    /// measure.
    double chooseStep(const Goal& goal);
    /// Of the march's picture, which the march forgets.
    PictureErrors errorsOf(const Image& picture, double brightest);

  private:
    Image draw(double stepVoxels);

    March& march_;
    std::uint32_t features_;
    PreparedScene& scene_;
    std::function<void(March&, Work&)> run_;
    Ledger& ram_;
    PixelGrid grid_;
};

} // namespace tessera
