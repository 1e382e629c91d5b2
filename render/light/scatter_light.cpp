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

AddedLight::AddedLight(const VolumeInfo& info, const Lighting& lighting, std::unique_ptr<LightSource> ambient)
    : info_(info), ambient_(std::move(ambient)) {
    int casters = 0;
    for (const Light& light : shiningLights(lighting.lights)) {
        const bool casts = !castingLights({light}).empty();
        if (light.scatter > 0)
            sources_.push_back({light, casts ? casters : -1});
        casters += casts ? 1 : 0;
    }
    TESSERA_CHECK(!sources_.empty());
}

void AddedLight::functionChanged(const TransferTable& table, const Optics& optics) {
    if (ambient_)
        ambient_->functionChanged(table, optics);
}

const ShadowMaps* AddedLight::mapsOf(const Source& source) const {
    return source.caster < 0 ? nullptr : &shadows_[static_cast<std::size_t>(source.caster)];
}

glm::vec3 AddedLight::sentBy(const Source& source) {
    return glm::vec3(source.light.scatter * source.light.intensity * source.light.colour);
}

float AddedLight::attenuation(const Source& source, const glm::dvec3& place) const {
    const Light& light = source.light;
    if (light.kind != LightKind::point)
        return 1;
    const ShadowMaps* const maps = mapsOf(source);
    const double mm = glm::distance(maps ? maps->position() : light.position, place);
    return static_cast<float>(light.attenuation.x + mm * light.attenuation.y + mm * mm * light.attenuation.z);
}

void AddedLight::fill(const ChunkKey& chunk, BrickCache& cache, OcclusionRoom& room,
                      std::uint16_t* texels) const {
    if (ambient_) {
        ambient_->fill(chunk, cache, room, texels);
        for (std::size_t c = 1; c < 3 && ambient_->channels() == 1; ++c)
            for (const OcclusionRoom::Run& run : room.runs)
                std::copy_n(texels + run.to, kPlaces, texels + c * kChunkTexels + run.to);
    }
    for (const Source& source : sources_)
        TESSERA_CHECK(source.caster < static_cast<int>(shadows_.size()));
    add(chunk, cache, room, [&](std::size_t n, const glm::vec3& light) {
        for (std::size_t c = 0; c < 3; ++c) {
            std::uint16_t& texel = texels[c * kChunkTexels + n];
            const float before = ambient_ ? static_cast<float>(texel) * (1 / leaf::kLightOne) : 1.0f;
            texel = lightTexel(before + light[static_cast<int>(c)]);
        }
    });
}

ScatterLight::ScatterLight(const VolumeInfo& info, const Statistics& statistics, const Lighting& lighting,
                           std::unique_ptr<LightSource> ambient)
    : AddedLight(info, lighting, std::move(ambient)), tissue_(info, statistics, raysOf(lighting)) {
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
    return std::max(tissue_.finestLevel(), AddedLight::finestLevel());
}

void ScatterLight::functionChanged(const TransferTable& table, const Optics& optics) {
    tissue_.setFunction(table, optics);
    AddedLight::functionChanged(table, optics);
}

/// The sum of the lights that get to samples, by their factors.
void ScatterLight::at(int level, const glm::ivec3& first, std::span<glm::vec3> out) const {
    const double voxels = std::ldexp(1, level);
    const glm::dvec3 place(info().patientFromVoxel * glm::dvec4((glm::dvec3(first) + 0.5) * voxels, 1)),
        step = voxels * glm::dvec3(info().patientFromVoxel[0]);
    std::fill(out.begin(), out.end(), glm::vec3(0));
    for (const Source& source : sources()) {
        const glm::vec3 sent = sentBy(source);
        for (std::size_t from = 0; from < out.size(); from += kPlaces) {
            const glm::dvec3 start = place + static_cast<double>(from) * step;
            std::array<float, kPlaces> left;
            left.fill(1);
            if (const ShadowMaps* const maps = mapsOf(source))
                maps->light(start, step, level, tissue_.target(), left.data());
            const std::size_t count = std::min<std::size_t>(kPlaces, out.size() - from);
            for (std::size_t n = 0; n < count; ++n)
                out[from + n] += left[n] / attenuation(source, start + static_cast<double>(n) * step) * sent;
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

void ScatterLight::add(const ChunkKey& chunk, BrickCache& cache, const OcclusionRoom& room,
                       const Add& put) const {
    std::unique_ptr<OcclusionRoom> mine = takeRoom();
    tissue_.occlude(chunk, room, cache, *mine);
    for (const OcclusionRoom::Run& run : room.runs)
        for (std::size_t n = run.to; n < run.to + kPlaces; ++n)
            put(n, {mine->shine[0][n], mine->shine[1][n], mine->shine[2][n]});
    const std::lock_guard lock(mutex_);
    rooms_.push_back(std::move(mine));
}

} // namespace tessera
