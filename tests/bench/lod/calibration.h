// tests/bench/lod/calibration.h: the errors that pictures state beside their true errors, and how often a
// statement holds.
#pragma once

#include "core/image/image_metrics.h"
#include "render/verify/measured_errors.h"
#include "tests/bench/lod/area_truth.h"
#include "tests/bench/lod/workbench.h"
#include "tests/bench/report/report.h"

#include <optional>
#include <string>
#include <vector>

namespace tessera::bench {

/// Of --max-error.
constexpr double kCalibratedMaxErrors[] = {1, 3, 10};

/// A picture that was drawn, what it says of itself, and what is.
struct CalibrationCase {
    std::string volume, preset, view;
    bool seenBefore = false, lit = false;
    std::string setting;          // "floor", "ample", "--max-error 3"
    std::optional<double> asked;  // --max-error
    std::size_t budgetBytes = 0;  // GPU memory
    double predictedP99 = 0;      // levels, step and filtering together, before anything is measured
    MeasuredErrors measured;      // of the picture
    MeasuredErrors samples, rays; // causes apart
    std::string whyNot, shortfall;
    ImageDifference is; // to the truth
    double samplesPerPixel = 0, stepVoxels = 0, seconds = 0;
    int level = 0, rounds = 0; // finest; pictures drawn
    std::size_t bytes = 0;     // of bricks, brought
    Image image;               // until it is compared
};

/// The truth that a few cases share.
struct CalibrationScene {
    std::string name;
    AreaTruth truth;
};

/// Scenes of a volume, its functions in turn from three sides, plain and lit in turn.
/// @param pixels  of pictures, an axis
/// @param turn    counts functions over all volumes; goes on
void calibrate(const Workbench& bench, const BenchVolume& volume, int pixels, const AreaTruthEffort& effort,
               const std::vector<double>& maxErrors, int& turn, std::vector<CalibrationCase>& cases,
               std::vector<CalibrationScene>& scenes);

/// How often what is said holds. Shares are of the cases that they can be told of; those with none are 0 of
/// 0.
struct CalibrationShares {
    struct Share {
        int hold = 0, of = 0;
        double part() const { return of > 0 ? static_cast<double>(hold) / of : 0; }
    };
    int cases = 0;
    Share maxError;         // --max-error said to be kept, and the true p99 is within it
    int notReached = 0;     // --max-error said not to be kept
    Share p99, mean, rms;   // intervals that hold the truth
    Share bound;            // at or above the true p99
    int noP99 = 0;          // not measured
    double trueToP99 = 0;   // median of true over measured
    double trueToGuess = 0; // median of true over predicted
};
CalibrationShares sharesOf(const std::vector<const CalibrationCase*>& cases);

/// Points against the diagonal, those of each --max-error apart.
Plot calibrationPlot(const std::vector<CalibrationCase>& cases);

} // namespace tessera::bench
