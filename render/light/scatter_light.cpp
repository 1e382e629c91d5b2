// render/light/scatter_light.cpp: see scatter_light.h.
#include "render/light/scatter_light.h"

#include "core/base/error.h"
#include "render/contract/leaves.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <utility>

namespace tessera {
namespace {

constexpr int kPlaces = native::kOcclusionRun; // looked up together

/// Rays of local occlusion, along which light is gathered.
Occlusion raysOf(const Lighting& lighting) {
    return {.rays = ScatterLight::kRays, .radiusMm = lighting.scatterRadiusMm, .emission = 1};
}

} // namespace

ScatterLight::ScatterLight(const VolumeInfo& info, const Statistics& statistics, const Lighting& lighting,
                           std::unique_ptr<LightSource> ambient)
    : info_(info), tissue_(info, statistics, raysOf(lighting)), ambient_(std::move(ambient)) {
    int casters = 0;
    for (const Light& light : shiningLights(lighting.lights)) {
        const bool casts = !castingLights({light}).empty();
        if (light.scatter > 0)
            sources_.push_back({light, casts ? casters : -1});
        casters += casts ? 1 : 0;
    }
    TESSERA_CHECK(!sources_.empty());
    tissue_.setScattered(this);
}

std::size_t ScatterLight::bytes(const VolumeInfo& info, const Lighting& lighting, int threads) {
    const Occlusion rays = raysOf(lighting);
    glm::ivec3 reach(0);
    for (int level = occlusionLevel(rays, info); level < kLevelCount; ++level)
        reach = glm::max(reach, occlusionRays(rays, info, level).reach);
    return static_cast<std::size_t>(threads) * OcclusionRoom::bytes(reach, true) +
           ChunkExtinctions::bytes(info, threads);
}

int ScatterLight::finestLevel() const {
    return std::max(tissue_.finestLevel(), ambient_ ? ambient_->finestLevel() : 0);
}

void ScatterLight::setShadows(std::span<const ShadowMaps> shadows) {
    shadows_ = shadows;
}

void ScatterLight::functionChanged(const TransferTable& table, const Optics& optics) {
    tissue_.setFunction(table, optics);
    if (ambient_)
        ambient_->functionChanged(table, optics);
}

/// The sum of the lights that get to samples, by their factors.
void ScatterLight::at(int level, const glm::ivec3& first, std::span<glm::vec3> out) const {
    const double voxels = std::ldexp(1, level);
    const glm::dvec3 place(info_.patientFromVoxel * glm::dvec4((glm::dvec3(first) + 0.5) * voxels, 1)),
        step = voxels * glm::dvec3(info_.patientFromVoxel[0]);
    std::fill(out.begin(), out.end(), glm::vec3(0));
    for (const Source& source : sources_) {
        const Light& light = source.light;
        const glm::vec3 sent(light.scatter * light.intensity * light.colour);
        const ShadowMaps* const maps =
            source.caster < 0 ? nullptr : &shadows_[static_cast<std::size_t>(source.caster)];
        for (std::size_t from = 0; from < out.size(); from += kPlaces) {
            const glm::dvec3 start = place + static_cast<double>(from) * step;
            std::array<float, kPlaces> left;
            left.fill(1);
            if (maps)
                maps->light(start, step, level, tissue_.target(), left.data());
            const std::size_t count = std::min<std::size_t>(kPlaces, out.size() - from);
            for (std::size_t n = 0; n < count; ++n) {
                if (light.kind == LightKind::point) {
                    const glm::dvec3 position = maps ? maps->position() : light.position;
                    const double mm = glm::distance(position, start + static_cast<double>(n) * step);
                    left[n] /= static_cast<float>(light.attenuation.x + mm * light.attenuation.y +
                                                  mm * mm * light.attenuation.z);
                }
                out[from + n] += left[n] * sent;
            }
        }
    }
}

std::unique_ptr<OcclusionRoom> ScatterLight::takeRoom() const {
    {
        const std::lock_guard lock(mutex_);
        if (!rooms_.empty()) {
            std::unique_ptr<OcclusionRoom> room = std::move(rooms_.back());
            rooms_.pop_back();
            return room;
        }
    }
    return std::make_unique<OcclusionRoom>(tissue_.mostReach(), true);
}

void ScatterLight::fill(const ChunkKey& chunk, BrickCache& cache, OcclusionRoom& room,
                        std::uint16_t* texels) const {
    if (ambient_) {
        ambient_->fill(chunk, cache, room, texels);
        for (std::size_t c = 1; c < 3 && ambient_->channels() == 1; ++c)
            for (const OcclusionRoom::Run& run : room.runs)
                std::copy_n(texels + run.to, kPlaces, texels + c * kChunkTexels + run.to);
    }
    for (const Source& source : sources_)
        TESSERA_CHECK(source.caster < static_cast<int>(shadows_.size()));
    std::unique_ptr<OcclusionRoom> mine = takeRoom();
    tissue_.occlude(chunk, room, cache, *mine);
    for (std::size_t c = 0; c < 3; ++c)
        for (const OcclusionRoom::Run& run : room.runs)
            for (std::size_t n = run.to; n < run.to + kPlaces; ++n) {
                std::uint16_t& texel = texels[c * kChunkTexels + n];
                const float before = ambient_ ? static_cast<float>(texel) * (1 / leaf::kLightOne) : 1.0f;
                texel = lightTexel(before + mine->shine[c][n]);
            }
    const std::lock_guard lock(mutex_);
    rooms_.push_back(std::move(mine));
}

} // namespace tessera
