// core/scene/lighting.cpp: see lighting.h.
#include "core/scene/lighting.h"

#include <algorithm>
#include <glm/geometric.hpp>

namespace tessera {

double directionWeight(const Occlusion& occlusion, const glm::dvec3& direction) {
    if (!occlusion.weights)
        return 1;
    // The mean over the sphere of a cosine above 0 is a quarter.
    const auto& [towards, strength] = *occlusion.weights;
    const double cosine = glm::dot(direction, glm::normalize(towards));
    return (1 + strength * std::max(0.0, cosine)) / (1 + strength / 4);
}

std::vector<Light> shiningLights(const std::vector<Light>& lights) {
    if (lights.empty())
        return {Light{}};
    std::vector<Light> shining = lights;
    std::erase_if(shining, [](const Light& l) { return !(l.intensity > 0) || l.colour == glm::dvec3(0); });
    return shining;
}

std::vector<Light> castingLights(const std::vector<Light>& lights) {
    std::vector<Light> casting = shiningLights(lights);
    std::erase_if(casting, [](const Light& l) { return !l.shadow || l.kind == LightKind::head; });
    return casting;
}

bool scatters(const Lighting& lighting) {
    const std::vector<Light> lights = shiningLights(lighting.lights);
    return std::any_of(lights.begin(), lights.end(), [](const Light& l) { return l.scatter > 0; });
}

bool scattersByMaps(const Lighting& lighting) {
    return lighting.scatterBy == ScatterSource::map && scatters(lighting);
}

int ambientChannels(const Lighting& lighting) {
    if (scatters(lighting))
        return 3;
    const auto& occlusion = lighting.occlusion;
    return !occlusion ? 0 : occlusion->emission > 0 || occlusion->bleeding > 0 ? 3 : 1;
}

int lightChannels(const Lighting& lighting) {
    return static_cast<int>(castingLights(lighting.lights).size()) + ambientChannels(lighting);
}

int keptLightChannels(const Lighting& lighting) {
    const int channels = lightChannels(lighting);
    return channels == 3 ? 4 : channels;
}

bool isHeadLightAlone(const std::vector<Light>& lights) {
    const std::vector<Light> shining = shiningLights(lights);
    return shining.size() == 1 && shining[0].kind == LightKind::head && shining[0].intensity == 1 &&
           shining[0].colour == glm::dvec3(1);
}

double maxIncidentLight(const std::vector<Light>& lights) {
    glm::dvec3 sum(0);
    for (const Light& l : shiningLights(lights)) // attenuation is largest at the light itself
        sum += l.colour * (l.kind == LightKind::point ? l.intensity / l.attenuation.x : l.intensity);
    return std::max({sum.r, sum.g, sum.b});
}

} // namespace tessera
