// render/light/light_map.cpp: see light_map.h.
#include "render/light/light_map.h"

#include "core/base/error.h"
#include "render/contract/leaves.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

namespace tessera {

LightGrid LightGrid::between(double nearMm, double farMm, double rayMm, int size, bool perspective) {
    LightGrid grid;
    grid.size = size;
    grid.nearMm = nearMm;
    grid.rayMm = rayMm;
    grid.perspective = perspective;
    const double length = std::max(1e-6, farMm - nearMm);
    const double apart = perspective ? rayMm * 0.5 * (nearMm + farMm) : rayMm;
    grid.slices = static_cast<int>(std::clamp(std::ceil(length / std::max(1e-9, apart)), 1.0, double(size)));
    grid.sliceMm = length / grid.slices;
    return grid;
}

void addToSlices(const LightGrid& grid, float fromMm, float toMm, float depth, const glm::vec3& albedo,
                 std::span<LightSlice> slices) {
    const auto placeOf = [&](float mm) { return (static_cast<double>(mm) - grid.nearMm) / grid.sliceMm; };
    const int last = static_cast<int>(slices.size()) - 1;
    const double from = placeOf(fromMm), to = std::max(from, placeOf(toMm));
    const int first = std::clamp(static_cast<int>(std::floor(from)), 0, last),
              end = std::clamp(static_cast<int>(std::floor(to)), 0, last);
    for (int k = first; k <= end; ++k) {
        const double low = k == first ? from : k, high = k == end ? to : k + 1;
        const auto share = static_cast<float>(first == end ? 1 : (high - low) / (to - from));
        slices[static_cast<std::size_t>(k)].depth += share * depth;
        slices[static_cast<std::size_t>(k)].albedo += share * depth * albedo;
    }
}

void finishSlices(const LightGrid& grid, float endMm, std::span<LightSlice> slices) {
    for (LightSlice& slice : slices)
        slice.albedo = slice.depth > 0 ? slice.albedo / slice.depth : glm::vec3(0);
    if (endMm < 0)
        return;
    const double place = (static_cast<double>(endMm) - grid.nearMm) / grid.sliceMm;
    const auto count = static_cast<int>(slices.size());
    // The slice in which a ray ends may not be whole: it and those behind it are as the one before, if that
    // is the deeper one.
    const int from = std::clamp(static_cast<int>(std::floor(place)), 0, count - 1);
    const auto depth = [&](int n) { return slices[static_cast<std::size_t>(n)].depth; };
    const int known = from > 0 && depth(from - 1) > depth(from) ? from - 1 : from;
    std::fill(slices.begin() + known + 1, slices.end(), slices[static_cast<std::size_t>(known)]);
}

std::size_t LightMap::bytes(int size) {
    LightGrid grid;
    grid.size = grid.slices = size;
    return 3 * sizeof(std::uint16_t) * grid.nodes();
}

glm::vec3 LightMap::at(const glm::vec2& at, float mm) const {
    const auto edge = static_cast<float>(grid_.size);
    const auto plane = static_cast<float>((static_cast<double>(mm) - grid_.nearMm) / grid_.sliceMm);
    const glm::vec3 most(edge - 1, edge - 1, static_cast<float>(grid_.slices));
    const glm::vec3 place = glm::clamp(glm::vec3(at - 0.5f, plane), glm::vec3(0), most);
    const glm::ivec3 low = glm::min(glm::ivec3(place), glm::max(glm::ivec3(most) - 1, glm::ivec3(0)));
    const glm::vec3 part = place - glm::vec3(low);
    // With one ray there is no second one beside it.
    const std::size_t right = grid_.size > 1 ? 1 : 0, below = right * static_cast<std::size_t>(grid_.size),
                      behind = grid_.nodesOfPlane();
    const std::size_t first = static_cast<std::size_t>(low.z) * behind +
                              static_cast<std::size_t>(low.y) * static_cast<std::size_t>(grid_.size) +
                              static_cast<std::size_t>(low.x);
    const auto row = [&](std::size_t n) {
        const std::uint16_t *const a = node(n), *const b = node(n + right);
        const glm::vec3 left(a[0], a[1], a[2]);
        return left + part.x * (glm::vec3(b[0], b[1], b[2]) - left);
    };
    const auto between = [&](std::size_t n) {
        const glm::vec3 above = row(n);
        return above + part.y * (row(n + below) - above);
    };
    const glm::vec3 before = between(first);
    return (1 / leaf::kLightOne) * (before + part.z * (between(first + behind) - before));
}

} // namespace tessera
