// render/plan/step_search.h: draws some of a picture's pixels again: before the picture to choose step and
// integrator, afterwards to estimate its error.
#pragma once

#include "core/image/image.h"
#include "core/image/image_metrics.h"
#include "render/contract/ray.h"
#include "render/contract/strides.h"
#include "render/plan/planner.h"

#include <functional>
#include <glm/vec2.hpp>
#include <optional>

namespace tessera {

// Estimates of a picture's error from itself: some pixels drawn again with other steps and with exact
// fetches. Each cause is estimated separately. Comparisons are with better pictures of the same renderer, not
// with the truth.

/// The grid of thinned() with the least stride that leaves at most kMostPixels pixels along an axis.
class PixelGrid {
  public:
    static constexpr int kMostPixels = 48;
    explicit PixelGrid(const glm::ivec2& imageSize);
    const glm::ivec2& size() const { return size_; } // pixels of the grid
    /// Draws the picture's rays through the grid's pixels, with segments of a length in voxels; in hulls with
    /// as many times the samples as segments are shorter.
    RayFrame<double> frame(const RayFrame<double>& picture, double segmentVoxels) const;
    Image of(const Image& picture) const;

  private:
    glm::ivec2 picture_, size_;
    int every_;
};

/// An error of a picture, over the grid's pixels: linear light, all four components; CIE L*u*v*.
struct EstimatedError {
    double rms = 0, largest = 0, luvMean = 0, luvP99 = 0;
};

struct StepError {
    EstimatedError error; // of the picture's step, against a quarter of it
    double order = 0;     // order of convergence: of the difference to half the step
};

/// @param picture, half, quarter  the grid's pixels with the picture's step, half and a quarter of it
StepError stepError(const Image& picture, const Image& half, const Image& quarter);
/// The error of a picture against a better one.
EstimatedError errorBetween(const Image& picture, const Image& better);

/// The estimated errors of a picture by cause. None: unknown, or no such cause.
struct PictureErrors {
    int pixels = 0; // pixels drawn again
    std::optional<StepError> step;
    std::optional<EstimatedError> filtering; // filtered against exact fetches
    double terminationBound = 0;             // upper bound of a component's loss in a pixel; linear light
    double tableRelativeError = 0;           // of extinction, relative to its largest
    std::optional<double> levelsLuvP99;      // predicted
    /// Sum of the 99th percentiles of step, filtering and levels, L*u*v*.
    double luvP99() const;
};

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
    /// Chooses the cheapest integrator and number of samples in each hull, 1, 2, 4, ..., that agree with four
    /// times as many to 1/255 (rms) and kLuvOfLonger.
    void chooseHullSamples();
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
    /// @param drawMine  gives the picture's pixels; called where they are needed
    PictureErrors errorsOfGrid(const std::function<Image()>& drawMine, double brightest);

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
