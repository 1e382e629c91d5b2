// render/geometry/mesh_light.cpp: see mesh_light.h.
#include "render/geometry/mesh_light.h"

#include "render/geometry/shape_shade.h"
#include "render/light/scene_light.h"
#include "render/plan/fusion.h"

#include <glm/geometric.hpp>

namespace tessera {
namespace {

/// Rays to lights begin so far before a surface, mm, that its own rounding does not shade it.
constexpr double kAwayMm = 1e-3;
constexpr double kBeyondMm = 1e7;

bool casts(const Light& light) {
    return !castingLights({light}).empty();
}

} // namespace

bool MeshLight::isNeeded(const FramePlan& plan) {
    return !plan.view.meshes.empty() && plan.layer().optics.shading &&
           !castingLights(plan.view.lighting.lights).empty();
}

MeshLight::MeshLight(const FramePlan& plan, int threads) : plan_(plan) {
    std::vector<const FramePlan*> volumes = {&plan};
    for (const auto& volume : plan.further)
        volumes.push_back(&volume->plan);
    for (const Light& light : shiningLights(plan.view.lighting.lights)) {
        Source source{placedLight(light, plan.view.camera), {}};
        for (const FramePlan* volume : volumes)
            if (casts(light)) {
                LightPath field = lightPathOf(*volume, nullptr);
                field.meshes = {}; // rays find these
                ShadowQuality quality = shadowQualityOf(*volume);
                quality.lightMap.reset(); // meshes take no scattered light
                source.maps.emplace_back(source.light, field, quality);
                source.maps.back().build(field, threads);
            }
        sources_.push_back(std::move(source));
    }
}

MeshLight::Shares MeshLight::at(const glm::dvec3& place, const glm::dvec3& normal) const {
    Shares shares;
    shares.fill(1);
    for (std::size_t n = 0; n < sources_.size(); ++n) {
        const Source& source = sources_[n];
        if (source.maps.empty())
            continue;
        const glm::dvec3 way = source.light.isPoint ? source.light.position - place : source.light.towards;
        const double length = glm::length(way);
        if (!(length > 0) || !(glm::dot(way, normal) > 0)) { // it lights the other side
            shares[n] = 0;
            continue;
        }
        shares[n] = shadeBetween(plan_.view.meshes, {place + kAwayMm * normal, way / length}, 0,
                                 source.light.isPoint ? length : kBeyondMm);
        for (const ShadowMaps& maps : source.maps)
            if (shares[n] > 0)
                shares[n] *= static_cast<double>(maps.light(place));
    }
    return shares;
}

} // namespace tessera
