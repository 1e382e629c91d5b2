// bricking/analysis/body/distance_field.cpp: see distance_field.h.
#include "bricking/analysis/body/distance_field.h"

#include "core/base/brick.h" // linearIndex
#include "core/base/lower_envelope.h"

#include <cstddef>
#include <limits>

namespace tessera {

void squaredDistances(std::vector<float>& grid, const glm::ivec3& extent, const glm::dvec3& spacingMm) {
    LowerEnvelope envelope;
    std::vector<double> line;
    const glm::ivec3 strides(1, extent.x, extent.x * extent.y);
    for (int axis = 0; axis < 3; ++axis) {
        glm::ivec3 lines = extent; // one line for each place of the other two axes
        lines[axis] = 1;
        line.resize(static_cast<std::size_t>(extent[axis]));
        for (std::size_t n = 0; n < cellCount(lines); ++n) {
            float* const at = grid.data() + linearIndex(gridPosition(n, lines), extent);
            for (std::size_t i = 0; i < line.size(); ++i) {
                const float value = at[static_cast<std::ptrdiff_t>(i) * strides[axis]];
                line[i] =
                    value < kFarAway ? static_cast<double>(value) : std::numeric_limits<double>::infinity();
            }
            envelope.transform(line, spacingMm[axis]);
            for (std::size_t i = 0; i < line.size(); ++i)
                at[static_cast<std::ptrdiff_t>(i) * strides[axis]] =
                    line[i] < static_cast<double>(kFarAway) ? static_cast<float>(line[i]) : kFarAway;
        }
    }
}

} // namespace tessera
