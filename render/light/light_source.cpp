// render/light/light_source.cpp: see light_source.h.
#include "render/light/light_source.h"

#include "core/base/error.h"
#include "render/contract/leaves.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tessera {

std::uint16_t lightTexel(float light) {
    // Not std::lround(), which is a call: of numbers from 0 on this is the same. What is no number is dark.
    const double rounded = static_cast<double>(light * leaf::kLightOne) + 0.5;
    return static_cast<std::uint16_t>(std::min(std::max(0.0, rounded), 65535.0));
}

void OcclusionLight::fill(const ChunkKey& chunk, BrickCache&, OcclusionRoom& room,
                          std::uint16_t* texels) const {
    occluder_.occlude(chunk, room);
    const auto bias = static_cast<float>(occlusion_.bias), gamma = static_cast<float>(occlusion_.gamma);
    const std::size_t colours = occluder_.gathersEmission() ? 3 : 1;
    for (std::size_t c = 0; c < colours; ++c, texels += kChunkTexels)
        for (const OcclusionRoom::Run& run : room.runs)
            for (std::size_t n = run.to; n < run.to + native::kOcclusionRun; ++n)
                texels[n] = lightTexel(
                    std::pow(bias + room.light[n] + (colours > 1 ? room.shine[c][n] : 0.0f), gamma));
}

void ShadowLight::setShadows(std::span<const ShadowMaps> shadows) {
    TESSERA_CHECK(shadows.empty() || static_cast<int>(shadows.size()) == channels_);
    shadows_ = shadows;
}

void ShadowLight::setOtherShadows(std::vector<std::span<const ShadowMaps>> others) {
    for (const auto& shadows : others)
        TESSERA_CHECK(static_cast<int>(shadows.size()) == channels_);
    otherShadows_ = std::move(others);
}

void ShadowLight::fill(const ChunkKey& chunk, BrickCache&, OcclusionRoom& room, std::uint16_t* texels) const {
    const double voxels = std::ldexp(1, chunk.level);
    const glm::ivec3 corner = glm::ivec3(chunk.i, chunk.j, chunk.k) * kChunkExtent;
    for (std::size_t caster = 0; caster < shadows_.size(); ++caster) {
        for (const OcclusionRoom::Run& run : room.runs) {
            const glm::dvec3 first = (glm::dvec3(corner + run.at) + 0.5) * voxels;
            const glm::dvec3 place(info_.patientFromVoxel * glm::dvec4(first, 1)),
                step = voxels * glm::dvec3(info_.patientFromVoxel[0]);
            float light[native::kOcclusionRun];
            shadows_[caster].light(place, step, chunk.level, target_, light);
            for (const auto& others : otherShadows_) {
                float more[native::kOcclusionRun];
                others[caster].light(place, step, chunk.level, target_, more);
                for (int n = 0; n < native::kOcclusionRun; ++n)
                    light[n] *= more[n];
            }
            for (int n = 0; n < native::kOcclusionRun; ++n)
                texels[run.to + static_cast<std::size_t>(n)] = lightTexel(light[n]);
        }
        texels += kChunkTexels;
    }
}

} // namespace tessera
