// render/backends/reference/reference_integrator.cpp: the eight-point Gauss rule, computed rather than typed
// in.
#include "render/backends/reference/reference_integrator.h"

#include <numbers>

namespace tessera {

const ReferenceIntegrator::Rule& ReferenceIntegrator::gauss8() {
    static const Rule rule = [] {
        constexpr int n = 8;
        Rule r{};
        for (int i = 0; i < n; ++i) { // roots of P_8 by Newton from the usual cosine guess
            double x = std::cos(std::numbers::pi * (i + 0.75) / (n + 0.5)), slope = 0;
            for (int turn = 0; turn < 100; ++turn) {
                double p0 = 1, p1 = x;
                for (int k = 2; k <= n; ++k) {
                    const double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
                    p0 = p1;
                    p1 = p2;
                }
                slope = n * (x * p1 - p0) / (x * x - 1);
                const double step = p1 / slope;
                x -= step;
                if (std::abs(step) < 1e-17)
                    break;
            }
            const auto at = static_cast<std::size_t>(n - 1 - i); // ascending
            r.node[at] = 0.5 * (1 + x);
            r.weight[at] = 1 / ((1 - x * x) * slope * slope);
        }
        // A Lagrange polynomial has degree 7, so the rule itself, scaled to [0,node], integrates it exactly.
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t j = 0; j < n; ++j)
                for (std::size_t q = 0; q < n; ++q) {
                    const double t = r.node[i] * r.node[q];
                    double lagrange = 1;
                    for (std::size_t m = 0; m < n; ++m)
                        if (m != j)
                            lagrange *= (t - r.node[m]) / (r.node[j] - r.node[m]);
                    r.inner[j][i] += r.node[i] * r.weight[q] * lagrange;
                }
        return r;
    }();
    return rule;
}

} // namespace tessera
