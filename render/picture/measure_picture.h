// render/picture/measure_picture.h: measures the error of a picture just drawn. Pixels are drawn again on the
// engine that drew it, within the same budgets. Where the picture has coarser levels, they go through the
// finest.
#pragma once

#include "core/scene/scene.h"
#include "render/engine.h"
#include "render/picture/pixels_again.h"
#include "render/plan/scene_plan.h"

#include <memory>

namespace tessera {

struct DrawnPicture {
    const Scene& scene;
    const Image& image;
    const Work& work;           // that it took
    double samplesPerPixel = 1; // in the mean
    Verify mode = Verify::quick;
    int round = 0, rounds = 1; // of measurements of this picture, and how many there may be
    Slicing slicing;
};

/// @param caster  of the engine; where coarser levels were drawn it is let go of, the engine takes the finest
///     levels instead, and the plan is of these afterwards
/// A picture of 512 x 512 pixels and more pays a quarter of its bytes at most for Verify::quick; what cannot
/// be measured for that, or in these budgets, is said and not guessed.
PictureMeasurement measurePicture(const DrawnPicture& picture, ScenePlan& plan, Engine& engine,
                                  std::unique_ptr<RayCaster>& caster, const FrameContext& context);

} // namespace tessera
