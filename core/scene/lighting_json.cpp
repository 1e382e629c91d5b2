// core/scene/lighting_json.cpp: see lighting_json.h.
#include "core/scene/lighting_json.h"

#include "core/base/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

namespace tessera {
namespace {

using nlohmann::json;
using Keys = std::vector<std::string>;

const Keys kKinds = {"head", "directional", "point"};       // in the order of LightKind
const Keys kMethods = {"local", "positional", "rejecting"}; // in the order of OcclusionMethod
const Keys kFrames = {"camera", "patient"};                 // in the order of LightFrame
constexpr double kMostMm = 1e7, kMostIntensity = 1e6, kMostSoftness = 60;
/// At the light itself; less would be more light than numbers hold.
constexpr double kLeastAttenuation = 1e-6, kMostAttenuation = 1e6;
/// As many as subdivided platonic solids have corners or faces.
constexpr std::array kRays = {4, 8, 16, 20, 32, 64, 80, 128, 320, 512};

template <typename Enum> Enum named(const JsonValue& value, const Keys& names) {
    const std::string name = value.oneOf(names);
    return static_cast<Enum>(std::find(names.begin(), names.end(), name) - names.begin());
}
glm::dvec3 vectorWithin(const JsonValue& value, double lowest, double highest, const char* expected) {
    if (!value.isList() || value.items().size() != 3)
        value.refuse(expected);
    glm::dvec3 v(0);
    for (int i = 0; i < 3; ++i)
        v[i] = value.items()[static_cast<std::size_t>(i)].number(lowest, highest);
    return v;
}
json threeOf(const glm::dvec3& v) {
    return {v.x, v.y, v.z};
}

Light parseLight(const JsonValue& value) {
    value.requireKeys(lightKeys());
    Light light;
    light.kind = named<LightKind>(value.at("kind"), kKinds);
    const auto onlyOf = [&](const char* key, LightKind kind, const char* which) {
        if (value.has(key) && light.kind != kind)
            throw badFile(value.place(), std::string("\"") + key + "\" of " + which + " light only",
                          "a " + kKinds[static_cast<std::size_t>(light.kind)] + " light with it");
    };
    onlyOf("direction", LightKind::directional, "a directional");
    onlyOf("position", LightKind::point, "a point");
    onlyOf("attenuation", LightKind::point, "a point");
    if (light.kind == LightKind::head && value.has("frame"))
        throw badFile(value.place(), "no \"frame\": a head light is at the eye", "one");
    if (value.has("frame"))
        light.frame = named<LightFrame>(value.at("frame"), kFrames);
    if (value.has("direction"))
        light.direction = vectorWithin(value.at("direction"), -kMostMm, kMostMm, "[x, y, z]");
    if (value.has("position"))
        light.position = vectorWithin(value.at("position"), -kMostMm, kMostMm, "[x, y, z], mm");
    if (value.has("attenuation")) {
        const JsonValue attenuation = value.at("attenuation");
        light.attenuation = vectorWithin(attenuation, 0, kMostAttenuation, "[constant, linear, quadratic]");
        attenuation.items()[0].number(kLeastAttenuation, kMostAttenuation);
    }
    if (value.has("intensity"))
        light.intensity = value.at("intensity").number(0, kMostIntensity);
    if (value.has("colour"))
        light.colour = vectorWithin(value.at("colour"), 0, 1, "[r, g, b], linear");
    if (value.has("shadow"))
        light.shadow = value.at("shadow").boolean();
    if (value.has("softness"))
        light.softness = value.at("softness").number(0, kMostSoftness);
    return light;
}

json lightJson(const Light& light) {
    json out = {{"kind", kKinds[static_cast<std::size_t>(light.kind)]},
                {"intensity", light.intensity},
                {"colour", threeOf(light.colour)},
                {"shadow", light.shadow},
                {"softness", light.softness}};
    if (light.kind != LightKind::head)
        out["frame"] = kFrames[static_cast<std::size_t>(light.frame)];
    if (light.kind == LightKind::directional)
        out["direction"] = threeOf(light.direction);
    if (light.kind == LightKind::point) {
        out["position"] = threeOf(light.position);
        out["attenuation"] = threeOf(light.attenuation);
    }
    return out;
}

Occlusion parseOcclusion(const JsonValue& value) {
    value.requireKeys(occlusionKeys());
    Occlusion occlusion;
    if (value.has("method"))
        occlusion.method = named<OcclusionMethod>(value.at("method"), kMethods);
    if (value.has("rays")) {
        occlusion.rays = value.at("rays").integer(kRays.front(), kRays.back());
        if (std::find(kRays.begin(), kRays.end(), occlusion.rays) == kRays.end())
            value.at("rays").refuse("one of 4, 8, 16, 20, 32, 64, 80, 128, 320, 512");
    }
    const auto read = [&](const char* key, double lowest, double highest, double& target) {
        if (value.has(key))
            target = value.at(key).number(lowest, highest);
    };
    constexpr double kLeast = 1e-6; // mm: above 0
    read("radius", kLeast, 1e4, occlusion.radiusMm);
    read("offset", 0, 1e3, occlusion.offsetMm);
    read("bias", 0, 1, occlusion.bias);
    read("gamma", kLeast, 8, occlusion.gamma);
    read("emission", 0, 100, occlusion.emission);
    return occlusion;
}

json occlusionJson(const Occlusion& occlusion) {
    return {{"method", kMethods[static_cast<std::size_t>(occlusion.method)]},
            {"rays", occlusion.rays},
            {"radius", occlusion.radiusMm},
            {"offset", occlusion.offsetMm},
            {"bias", occlusion.bias},
            {"gamma", occlusion.gamma},
            {"emission", occlusion.emission}};
}

SurfaceOcclusion parseSurfaceOcclusion(const JsonValue& value) {
    value.requireKeys(surfaceOcclusionKeys());
    SurfaceOcclusion occlusion;
    if (value.has("rays"))
        occlusion.rays = value.at("rays").integer(1, SurfaceOcclusion::kMostRays);
    if (value.has("radius"))
        occlusion.radiusMm = value.at("radius").number(1e-3, 1e4);
    if (value.has("filter"))
        occlusion.filter = value.at("filter").boolean();
    return occlusion;
}

json surfaceOcclusionJson(const SurfaceOcclusion& occlusion) {
    return {{"rays", occlusion.rays}, {"radius", occlusion.radiusMm}, {"filter", occlusion.filter}};
}

} // namespace

const Keys& lightingKeys() {
    static const Keys keys = {"lights", "occlusion", "surfaceOcclusion", "finestLevel"};
    return keys;
}
const Keys& lightKeys() {
    static const Keys keys = {"kind",      "frame",  "direction", "position", "attenuation",
                              "intensity", "colour", "shadow",    "softness"};
    return keys;
}
const Keys& occlusionKeys() {
    static const Keys keys = {"method", "rays", "radius", "offset", "bias", "gamma", "emission"};
    return keys;
}

const Keys& surfaceOcclusionKeys() {
    static const Keys keys = {"rays", "radius", "filter"};
    return keys;
}

Lighting parseLighting(const JsonValue& value) {
    value.requireKeys(lightingKeys());
    Lighting lighting;
    if (value.has("lights")) {
        const JsonValue lights = value.at("lights");
        const JsonItems items = lights.items();
        if (items.empty() || items.size() > Lighting::kMaxLights)
            lights.refuse("1 to " + std::to_string(Lighting::kMaxLights) +
                          " lights (without the key: a head light)");
        for (const JsonValue& item : items)
            lighting.lights.push_back(parseLight(item));
    }
    if (value.has("occlusion"))
        lighting.occlusion = parseOcclusion(value.at("occlusion"));
    if (value.has("surfaceOcclusion"))
        lighting.surfaceOcclusion = parseSurfaceOcclusion(value.at("surfaceOcclusion"));
    if (lightChannels(lighting) > kMostLightChannels)
        value.refuse("at most " + std::to_string(kMostLightChannels - ambientChannels(lighting)) +
                     (ambientChannels(lighting) > 1 ? " light with a shadow beside occlusion with emission"
                                                    : " lights with shadows beside occlusion"));
    if (value.has("finestLevel"))
        lighting.finestLevel = value.at("finestLevel").integer(0, 3);
    return lighting;
}

json lightingJson(const Lighting& lighting) {
    json out;
    if (!lighting.lights.empty()) {
        out["lights"] = json::array();
        for (const Light& light : lighting.lights)
            out["lights"].push_back(lightJson(light));
    }
    if (lighting.occlusion)
        out["occlusion"] = occlusionJson(*lighting.occlusion);
    if (lighting.surfaceOcclusion)
        out["surfaceOcclusion"] = surfaceOcclusionJson(*lighting.surfaceOcclusion);
    if (lighting.finestLevel > 0)
        out["finestLevel"] = lighting.finestLevel;
    return out;
}

} // namespace tessera
