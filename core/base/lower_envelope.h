// core/base/lower_envelope.h: distances along a line to the nearest of several points. It is the step of an
// exact Euclidean distance transform that runs axis by axis (Felzenszwalb and Huttenlocher, Theory of
// Computing 8, 2012).
#pragma once

#include <cstddef>
#include <vector>

namespace tessera {

class LowerEnvelope {
  public:
    /// In place: f[i] = min over j of (i - j)^2 step^2 + f[j]. Infinite values are no points; a line of only
    /// these stays unchanged.
    /// @param step  between two values, mm; f is in mm^2
    void transform(std::vector<double>& f, double step);

  private:
    std::vector<std::size_t> parabola_;
    std::vector<double> border_, result_;
};

} // namespace tessera
