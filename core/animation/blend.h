// core/animation/blend.h: interpolation between two keyframes: transfer functions, lights, cuts and cameras.
// Parts that cannot be interpolated (another number of lights, another kind of cut) change at the later
// keyframe.
#pragma once

#include "core/animation/path.h"

#include <cstddef>
#include <vector>

namespace tessera {

/// share: 0: the first, 1: the second, both exactly.
/// Opacities and colours of every value are those of both, by their shares: kinks and steps of both stay.
/// Throws InputError for functions whose opacities are per different lengths.
TransferFunction blend(const TransferFunction& a, const TransferFunction& b, double share);
Lighting blend(const Lighting& a, const Lighting& b, double share);
Cuts blend(const Cuts& a, const Cuts& b, double share);

/// Progress between keyframes: a monotone function of time through (times, values), values not falling.
class Pace {
  public:
    /// @param times  rising
    /// @param easings  of what follows each
    Pace(std::vector<double> times, std::vector<double> values, const std::vector<Easing>& easings);
    struct Moment {
        std::size_t key = 0; // the keyframe that went before
        double value = 0;
    };
    /// Before the first keyframe the value is that of the first, after the last that of the last.
    Moment at(double time) const;

  private:
    std::vector<double> times_, values_, leaving_, arriving_; // slopes after each key, before the next
    std::vector<bool> held_;
};

/// The natural cubic spline through vectors, which have as many components as the first one: a curve with
/// continuous curvature.
class Spline {
  public:
    /// @param places  rising
    /// @param values  one for every place
    Spline(std::vector<double> places, std::vector<std::vector<double>> values);
    /// Clamped to the first and the last place.
    std::vector<double> at(double place) const;

  private:
    std::vector<double> places_;
    std::vector<std::vector<double>> values_, second_; // second derivatives
};

/// Cameras between those of keyframes: focal point, distance and orientation follow splines, parametrised by
/// the camera's movement. The eye never passes through the focal point.
class CameraCurve {
  public:
    /// Throws InputError naming where for cameras of both projections.
    CameraCurve(const std::vector<double>& times, const std::vector<Camera>& cameras,
                const std::vector<Easing>& easings, const std::string& where);
    Camera at(double time) const;

  private:
    Camera between(double place) const;
    std::vector<double> places_; // on the splines, of every keyframe
    std::vector<Camera> cameras_;
    std::vector<std::vector<double>>
        wayMm_; // of every segment: how far the camera has moved, evenly in place
    Spline spline_;
    Pace pace_;
};

} // namespace tessera
