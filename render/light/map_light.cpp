// render/light/map_light.cpp: see map_light.h.
#include "render/light/map_light.h"

#include <cmath>

namespace tessera {

void MapLight::add(const ChunkKey& chunk, BrickCache&, const OcclusionRoom& room, const Add& put) const {
    const double voxels = std::ldexp(1, chunk.level);
    const glm::ivec3 corner = glm::ivec3(chunk.i, chunk.j, chunk.k) * kChunkExtent;
    const glm::dvec3 step = voxels * glm::dvec3(info().patientFromVoxel[0]);
    for (const OcclusionRoom::Run& run : room.runs) {
        const glm::dvec3 first(info().patientFromVoxel *
                               glm::dvec4((glm::dvec3(corner + run.at) + 0.5) * voxels, 1));
        for (std::size_t n = 0; n < native::kOcclusionRun; ++n) {
            const glm::dvec3 place = first + static_cast<double>(n) * step;
            glm::vec3 light(0);
            for (const Source& source : sources())
                if (mapsOf(source)) // a scene's own rules ask for them
                    light += sentBy(source) / attenuation(source, place) * mapsOf(source)->scattered(place);
            put(run.to + n, light);
        }
    }
}

} // namespace tessera
