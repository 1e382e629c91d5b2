// render/backends/reference/left_by_others.h: the light that other volumes leave along a ray of occlusion.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace tessera {

/// Depth by depth at places that are equally far apart: exact there, linear between.
class LeftByOthers {
  public:
    static constexpr int kParts = 64;
    /// @param mm  length of the ray
    /// @param left  share of light that is left of 1 behind a part: f(from, to), mm
    template <typename Left> LeftByOthers(double mm, const Left& left) : part_(mm / kParts) {
        depths_.push_back(0);
        for (int n = 0; n < kParts; ++n) {
            const double depth = -std::log(std::max(left(n * part_, (n + 1) * part_), 1e-12));
            depths_.push_back(depths_.back() + depth);
        }
    }
    double depth(double mm) const {
        const double at = std::clamp(mm / part_, 0.0, double{kParts});
        const auto n = std::min(static_cast<std::size_t>(at), depths_.size() - 2);
        return depths_[n] + (at - static_cast<double>(n)) * (depths_[n + 1] - depths_[n]);
    }
    double at(double mm) const { return std::exp(-depth(mm)); }
    /// The integral of at(), mm.
    double between(double from, double to) const {
        double sum = 0;
        for (double a = from; a < to;) {
            double b = std::min(to, (std::floor(a / part_ + 1e-9) + 1) * part_);
            if (!(b > a))
                b = to;
            const double lost = depth(b) - depth(a);
            sum += (b - a) * at(a) * (lost > 1e-8 ? -std::expm1(-lost) / lost : 1 - 0.5 * lost);
            a = b;
        }
        return sum;
    }

  private:
    double part_;
    std::vector<double> depths_; // from 0
};

} // namespace tessera
