// core/scene/light_fields.cpp: the keys of lights, and of all light together: see light_fields.h.
#include "core/scene/light_fields.h"
#include "core/base/error.h"

namespace tessera {

template <> const NameTable<LightKind>& namesOf() {
    static const NameTable<LightKind> names{
        {{LightKind::head, "head"}, {LightKind::directional, "directional"}, {LightKind::point, "point"}}};
    return names;
}
template <> const NameTable<LightFrame>& namesOf() {
    static const NameTable<LightFrame> names{
        {{LightFrame::camera, "camera"}, {LightFrame::patient, "patient"}}};
    return names;
}

template <> const NameTable<ScatterSource>& namesOf() {
    static const NameTable<ScatterSource> names{{ScatterSource::rays, "rays"}, {ScatterSource::map, "map"}};
    return names;
}

Kind<glm::dvec3> vectorWithin(double lowest, double highest, const std::string& expected) {
    return numbersWithin<glm::dvec3>(lowest, highest, expected, &glm::dvec3::x, &glm::dvec3::y,
                                     &glm::dvec3::z);
}

namespace {

constexpr double kMostSoftness = 60;
/// At the light itself; a lower attenuation would overflow.
constexpr double kLeastAttenuation = 1e-6, kMostAttenuation = 1e6;

/// Refuses a key of other kinds of light.
auto onlyOf(const std::string& key, LightKind kind, const std::string& which) {
    return [=](const Light& light, const JsonValue& whole) {
        if (light.kind != kind)
            throw badFile(whole.place(), "\"" + key + "\" of " + which + " light only",
                          "a " + nameOf(light.kind) + " light with it");
    };
}
auto isOf(LightKind kind) {
    return [kind](const Light& light) { return light.kind == kind; };
}

const Fields<Light>& lightFields() {
    static const Fields<Light> fields = [] {
        Fields<Light> f("light");
        f.add("kind", &Light::kind, named<LightKind>(),
              "head: at the eye, along every ray; directional: infinitely far away; point: at a position.")
            .required();
        f.add("frame", &Light::frame, named<LightFrame>(),
              "Directional and point lights only: frame of direction and position; patient: LPS. camera "
              "(default): x to the picture's right, y up, z towards the viewer. Its origin is the eye, in "
              "parallel projection the camera's position.")
            .allowedBy([](const Light& light, const JsonValue& whole) {
                if (light.kind == LightKind::head)
                    throw badFile(whole.place(), "no \"frame\": a head light is at the eye", "one");
            })
            .writtenIf([](const Light& light) { return light.kind != LightKind::head; });
        f.add("direction", &Light::direction, vectorWithin(-kFarthestLightMm, kFarthestLightMm, "[x, y, z]"),
              "Directional lights only: towards the light, of any length (default: [0, 0, 1]). [0, 0, 0] "
              "lights only what is shaded as a volume.")
            .allowedBy(onlyOf("direction", LightKind::directional, "a directional"))
            .writtenIf(isOf(LightKind::directional));
        f.add("position", &Light::position,
              vectorWithin(-kFarthestLightMm, kFarthestLightMm, "[x, y, z], mm"),
              "Point lights only: position, mm (default: [0, 0, 0]).")
            .allowedBy(onlyOf("position", LightKind::point, "a point"))
            .writtenIf(isOf(LightKind::point));
        f.add("attenuation", &Light::attenuation,
              vectorWithin(0, kMostAttenuation, "[constant, linear, quadratic]")
                  .checked([](const glm::dvec3&, const JsonValue& value) {
                      value.items()[0].number(kLeastAttenuation, kMostAttenuation);
                  }),
              "Point lights only: [c, l, q] of 1 / (c + l d + q d^2), d the distance in mm; c at least 1e-6 "
              "(default: [1, 0, 0]).")
            .allowedBy(onlyOf("attenuation", LightKind::point, "a point"))
            .writtenIf(isOf(LightKind::point));
        f.add("intensity", &Light::intensity, numberIn(0, kMostIntensity),
              "Brightness; 0: the light is left out.");
        f.add("colour", &Light::colour, colourKind(), "Colour, linear light.");
        f.add("shadow", &Light::shadow, trueOrFalse(), "The light casts shadows.");
        f.add("softness", &Light::softness, numberIn(0, kMostSoftness),
              "Apparent diameter of the light, degrees.");
        f.add("scatter", &Light::scatter, numberIn(0, 4),
              "Factor on the light that tissue around a place scatters to it, in the tissue's colour; 0: "
              "none.")
            .unlessDefault();
        f.rule([](const JsonValue& whole, const Light& light) {
            if (light.scatter > 0 && light.kind == LightKind::point && light.frame == LightFrame::camera &&
                !light.shadow)
                whole.refuse(
                    "\"shadow\": true of a point light with \"scatter\" in the camera's frame, so that "
                    "its light follows the camera");
        });
        return f;
    }();
    return fields;
}

const Fields<LightMapping>& lightMappingFields() {
    static const Fields<LightMapping> fields = [] {
        Fields<LightMapping> f("lightMap", "Light maps, with scatterBy map.");
        f.add("size", &LightMapping::size, wholeIn(LightMapping::kLeastSize, LightMapping::kMostSize),
              "Resolution: a map's rays along a side, half as many of a light with softness; it has as many "
              "slices at most.");
        f.add(
            "g", &LightMapping::g, numberIn(0, LightMapping::kMostG),
            "How much tissue scatters light onwards: the mean cosine of its phase function; 0: evenly to all "
            "sides.");
        return f;
    }();
    return fields;
}

} // namespace

const Fields<Lighting>& lightingFields() {
    static const Fields<Lighting> fields = [] {
        Fields<Lighting> f("lighting", "Lights, shadows and occlusion.");
        const std::string most = std::to_string(Lighting::kMaxLights);
        f.add("lights", &Lighting::lights,
              listOf(objectOf(lightFields()), 1, Lighting::kMaxLights,
                     "1 to " + most + " lights (without the key: a head light)"),
              "Without it: one white head light of intensity 1.")
            .unlessDefault();
        f.add("occlusion", &Lighting::occlusion, objectOf(occlusionFields()));
        f.add("surfaceOcclusion", &Lighting::surfaceOcclusion, objectOf(surfaceOcclusionFields()));
        f.add("transport", &Lighting::transport, objectOf(transportFields()));
        f.add("environment", &Lighting::environment, objectOf(environmentFields()));
        f.add("reflectionOrder", &Lighting::reflectionOrder, wholeIn(0, Lighting::kMostReflections),
              "How many isosurfaces with a reflection light may meet one after another; 0: they have none.")
            .unlessDefault();
        f.add("shadowMap", &Lighting::shadowMap, objectOf(shadowMappingFields())).unlessDefault();
        f.add("scatterBy", &Lighting::scatterBy, named<ScatterSource>(),
              "What brings scattered light (lights[].scatter) to a place. rays: the tissue within "
              "scatterRadius, lit by what is left of the light there. map: light maps, in which light is "
              "scattered on and back any number of times on its way through the volume, for tissue that is "
              "lit from behind.")
            .unlessDefault();
        f.add("scatterRadius", &Lighting::scatterRadiusMm, numberIn(1e-6, 1e4),
              "scatterBy rays: how far from a place tissue scatters light to it, mm.")
            .unlessDefault();
        f.add("lightMap", &Lighting::lightMap, objectOf(lightMappingFields())).unlessDefault();
        f.add("finestLevel", &Lighting::finestLevel, wholeIn(0, 3),
              "Resolution of light per voxel: 0: every sample; 1: one value per 2^3 voxels, interpolated; "
              "and so on.")
            .unlessDefault();
        f.rule([](const JsonValue& whole, const Lighting& lighting) {
            if (lighting.environment && lighting.transport &&
                lighting.transport->response != TransportResponse::physical)
                whole.refuse("\"transport\" of response \"physical\" beside \"environment\"");
            for (const Light& light : shiningLights(lighting.lights))
                if (lighting.scatterBy == ScatterSource::map && light.scatter > 0 &&
                    castingLights({light}).empty())
                    whole.refuse("\"shadow\": true of every light with \"scatter\", directional or a point, "
                                 "beside \"scatterBy\": \"map\", because light maps see what shadows do");
            const int ambient = ambientChannels(lighting);
            if (lightChannels(lighting) > kMostLightChannels)
                whole.refuse("at most " + std::to_string(kMostLightChannels - ambient) +
                             (ambient > 1 ? " light with a shadow beside scattered light, or occlusion with "
                                            "emission or bleeding"
                                          : " lights with shadows beside occlusion"));
        });
        return f;
    }();
    return fields;
}

} // namespace tessera
