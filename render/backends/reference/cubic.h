// render/backends/reference/cubic.h: a cubic: the form of fields and gradients along a ray between two planes
// of samples.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace tessera {

/// A cubic in u in [0,1] through its values at 0, 1/3, 2/3, 1.
struct Cubic {
    double c0, c1, c2, c3;
    /// From differences, so that equal values give a constant.
    Cubic(double f0, double f1, double f2, double f3) : c0(f0) {
        const double d1 = f1 - f0, d2 = f2 - f0, d3 = f3 - f0;
        c1 = 9 * d1 - 4.5 * d2 + d3;
        c2 = -22.5 * d1 + 18 * d2 - 4.5 * d3;
        c3 = 13.5 * d1 - 13.5 * d2 + 4.5 * d3;
    }
    template <typename V> V operator()(V u) const { return V(c0) + u * (V(c1) + u * (V(c2) + u * V(c3))); }

    double slope(double u) const { return c1 + u * (2 * c2 + u * (3 * c3)); }

    /// Ends of the pieces on which it is monotone, 0 and 1 included, ascending.
    std::size_t monotonePieces(std::array<double, 4>& ends) const {
        std::size_t n = 0;
        ends[n++] = 0;
        const double a = 3 * c3, b = 2 * c2, d = b * b - 4 * a * c1;
        if (d > 0 || a == 0) {
            std::array<double, 2> roots = {-1, -1};
            if (a == 0) {
                if (b != 0)
                    roots[0] = -c1 / b;
            } else {
                const double q = -0.5 * (b + std::copysign(std::sqrt(d), b));
                roots = {q / a, q != 0 ? c1 / q : -1};
            }
            std::sort(roots.begin(), roots.end());
            for (const double r : roots)
                if (r > ends[n - 1] && r < 1)
                    ends[n++] = r;
        }
        ends[n++] = 1;
        return n;
    }
};

/// Finds where monotone f crosses value between a and b; f(a) and f(b) lie on different sides. Newton steps,
/// or bisection where a step leaves the interval.
inline double crossing(const Cubic& f, double value, double a, double b) {
    constexpr double kNear = 1e-15; // convergence: the next step would be its square
    const bool rising = f(a) < value;
    double u = 0.5 * (a + b);
    for (int turn = 0; turn < 100 && b - a > kNear; ++turn) {
        const double here = f(u);
        ((here < value) == rising ? a : b) = u;
        double next = u - (here - value) / f.slope(u);
        if (!(next >= a && next <= b))
            next = 0.5 * (a + b);
        if (std::abs(next - u) <= kNear)
            return next;
        u = next;
    }
    return u;
}

} // namespace tessera
