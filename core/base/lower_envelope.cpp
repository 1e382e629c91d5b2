// core/base/lower_envelope.cpp: see lower_envelope.h.
#include "core/base/lower_envelope.h"

#include <algorithm>
#include <cmath>

namespace tessera {

void LowerEnvelope::transform(std::vector<double>& f, double step) {
    const std::size_t n = f.size();
    const auto finite = std::find_if(f.begin(), f.end(), [](double value) { return !std::isinf(value); });
    if (finite == f.end())
        return;
    parabola_.resize(n);
    border_.resize(n + 1);
    const double unit = step * step;
    const auto begin = static_cast<std::size_t>(finite - f.begin());
    std::size_t last = 0;
    parabola_[0] = begin;
    border_[0] = -1e30;
    border_[1] = 1e30;
    for (std::size_t q = begin + 1; q < n; ++q) {
        if (std::isinf(f[q]))
            continue;
        const auto meets = [&](std::size_t p) { // where parabola q gets below p
            const auto a = static_cast<double>(q), b = static_cast<double>(p);
            return (f[q] - f[p] + unit * (a * a - b * b)) / (2 * unit * (a - b));
        };
        double s = meets(parabola_[last]);
        while (s <= border_[last])
            s = meets(parabola_[--last]);
        parabola_[++last] = q;
        border_[last] = s;
        border_[last + 1] = 1e30;
    }
    result_.resize(n);
    std::size_t k = 0;
    for (std::size_t q = 0; q < n; ++q) {
        while (border_[k + 1] < static_cast<double>(q))
            ++k;
        const double away = static_cast<double>(q) - static_cast<double>(parabola_[k]);
        result_[q] = unit * away * away + f[parabola_[k]];
    }
    f.swap(result_);
}

} // namespace tessera
