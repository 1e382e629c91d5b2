// bricking/body/distance_field.cpp: see distance_field.h.
#include "bricking/body/distance_field.h"

#include "core/brick.h" // linearIndex

#include <algorithm>
#include <cstddef>

namespace tessera {
namespace {

/// One line of n values, a step apart: each becomes the least of value + (distance to it)^2.
class Line {
  public:
    explicit Line(int longest)
        : values_(static_cast<std::size_t>(longest)), places_(values_.size()), from_(values_.size() + 1) {}

    void run(float* at, std::ptrdiff_t stride, int n, double step) {
        int count = 0; // parabolas of the envelope: places_, each the lowest from from_ on
        for (int i = 0; i < n; ++i) {
            const double value = static_cast<double>(at[i * stride]);
            values_[static_cast<std::size_t>(i)] = value;
            if (value >= static_cast<double>(kFarAway))
                continue;
            double begin = -1e30;
            while (count > 0) {
                const int before = places_[static_cast<std::size_t>(count - 1)];
                const double a = before * step, b = i * step;
                begin = (value + b * b - values_[static_cast<std::size_t>(before)] - a * a) / (2 * (b - a));
                if (begin > from_[static_cast<std::size_t>(count - 1)])
                    break;
                --count;
                begin = -1e30;
            }
            places_[static_cast<std::size_t>(count)] = i;
            from_[static_cast<std::size_t>(count)] = begin;
            ++count;
        }
        for (int i = 0, k = 0; i < n && count > 0; ++i) {
            while (k + 1 < count && from_[static_cast<std::size_t>(k + 1)] < i * step)
                ++k;
            const int place = places_[static_cast<std::size_t>(k)];
            const double apart = (i - place) * step;
            at[i * stride] = static_cast<float>(values_[static_cast<std::size_t>(place)] + apart * apart);
        }
    }

  private:
    std::vector<double> values_;
    std::vector<int> places_;
    std::vector<double> from_;
};

} // namespace

void squaredDistances(std::vector<float>& grid, const glm::ivec3& extent, const glm::dvec3& spacingMm) {
    Line line(std::max({extent.x, extent.y, extent.z}));
    const glm::ivec3 strides(1, extent.x, extent.x * extent.y);
    for (int axis = 0; axis < 3; ++axis) {
        glm::ivec3 lines = extent; // one line for each place of the other two axes
        lines[axis] = 1;
        for (std::size_t n = 0; n < cellCount(lines); ++n)
            line.run(grid.data() + linearIndex(gridPosition(n, lines), extent), strides[axis], extent[axis],
                     spacingMm[axis]);
    }
}

} // namespace tessera
