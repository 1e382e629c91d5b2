// render/geometry/point_shape.cpp: see point_shape.h.
#include "render/geometry/point_shape.h"

#include <cstdint>
#include <numeric>
#include <vector>

namespace tessera {
namespace {

/// Every point is a line of its own.
std::vector<std::uint32_t> endsOf(std::size_t count) {
    std::vector<std::uint32_t> ends(count);
    std::iota(ends.begin(), ends.end(), 1u);
    return ends;
}

} // namespace

PointShape::PointShape(std::span<const glm::vec3> points, double radiusMm, MemoryBudget& ram)
    : TubeShape(Tube{{points.begin(), points.end()}, radiusMm}, endsOf(points.size()), ram) {}

} // namespace tessera
