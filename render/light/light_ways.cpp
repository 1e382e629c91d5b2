// render/light/light_ways.cpp: see light_ways.h.
#include "render/light/light_ways.h"

#include "render/contract/ray_cuts.h"

#include <algorithm>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace tessera {

void addWayParts(const RayFrame<double>& frame, const glm::dvec3& from, const glm::dvec3& voxelsPerMm,
                 double mostMm, std::vector<WayPart>& parts) {
    const double voxels = glm::length(voxelsPerMm);
    const RayLine<double> line{from, voxelsPerMm / voxels, 0, 1 / voxels};
    double t0 = 0, t1 = 0;
    if (!drawnPartOf(frame, line, t0, t1))
        return;
    t1 = std::min(t1, mostMm * voxels);
    std::vector<RayCuts::Part> kept(1, {t0, t1});
    if (frame.cuts && t0 < t1) {
        kept.clear();
        frame.cuts->parts(from, line.direction, t0, t1, kept);
    }
    for (const RayCuts::Part& part : kept)
        if (part.from < part.to)
            parts.push_back(
                {{from + part.from * line.direction, line.direction, part.to - part.from, line.mmPerVoxel},
                 part.from * line.mmPerVoxel});
}

glm::dvec3 pitchAlong(const FramePlan& plan, const glm::dvec3& voxel, const glm::dvec3& along, bool finest) {
    const Selection& selection = plan.layer().selection;
    const glm::ivec3 brick =
        glm::clamp(glm::ivec3(glm::floor(voxel)) / kBrickExtent, glm::ivec3(0), selection.bricks - 1);
    std::uint8_t level = selection.levels[linearIndex(brick, selection.bricks)];
    if (level == Selection::kEmpty)
        level = static_cast<std::uint8_t>(selection.finest());
    const double most = std::max({std::abs(along.x), std::abs(along.y), std::abs(along.z)});
    return along * ((finest ? 1 : 1 << level) / most);
}

} // namespace tessera
