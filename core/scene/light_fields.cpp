// core/scene/light_fields.cpp: the keys of shading, lights and occlusion: see scene_fields.h.
#include "core/base/error.h"
#include "core/base/magnitude.h"
#include "core/scene/scene_fields.h"

#include <algorithm>
#include <array>

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
template <> const NameTable<OcclusionMethod>& namesOf() {
    static const NameTable<OcclusionMethod> names{{{OcclusionMethod::local, "local"},
                                                   {OcclusionMethod::positional, "positional"},
                                                   {OcclusionMethod::rejecting, "rejecting"}}};
    return names;
}

namespace {

constexpr double kMostMm = 1e7, kMostIntensity = 1e6, kMostSoftness = 60;
/// At the light itself; less would be more light than numbers hold.
constexpr double kLeastAttenuation = 1e-6, kMostAttenuation = 1e6;
/// As many as subdivided platonic solids have corners or faces.
constexpr std::array kRays = {4, 8, 16, 20, 32, 64, 80, 128, 320, 512};
constexpr double kAboveZero = 1e-6;

Kind<glm::dvec3> within(double lowest, double highest, const std::string& expected) {
    return numbersWithin<glm::dvec3>(lowest, highest, expected, &glm::dvec3::x, &glm::dvec3::y,
                                     &glm::dvec3::z);
}

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
              "head: at the eye, along every ray; directional: from far away; point: from a place.")
            .required();
        f.add(
             "frame", &Light::frame, named<LightFrame>(),
             "Directional and point lights only: what direction and position are fixed to. camera (default): "
             "x to the picture's right, y up, z towards the viewer, positions from the eye (parallel "
             "projection: from the camera's position); patient: LPS.")
            .allowedBy([](const Light& light, const JsonValue& whole) {
                if (light.kind == LightKind::head)
                    throw badFile(whole.place(), "no \"frame\": a head light is at the eye", "one");
            })
            .writtenIf([](const Light& light) { return light.kind != LightKind::head; });
        f.add("direction", &Light::direction, within(-kMostMm, kMostMm, "[x, y, z]"),
              "Directional lights only: towards the light, any length (default: [0, 0, 1]); [0, 0, 0] lights "
              "nothing but the volume itself.")
            .allowedBy(onlyOf("direction", LightKind::directional, "a directional"))
            .writtenIf(isOf(LightKind::directional));
        f.add("position", &Light::position, within(-kMostMm, kMostMm, "[x, y, z], mm"),
              "Point lights only: mm (default: [0, 0, 0]).")
            .allowedBy(onlyOf("position", LightKind::point, "a point"))
            .writtenIf(isOf(LightKind::point));
        f.add("attenuation", &Light::attenuation,
              within(0, kMostAttenuation, "[constant, linear, quadratic]")
                  .checked([](const glm::dvec3&, const JsonValue& value) {
                      value.items()[0].number(kLeastAttenuation, kMostAttenuation);
                  }),
              "Point lights only: [c, l, q] of 1 / (c + l d + q d^2), d the distance in mm; c at least 1e-6 "
              "(default: [1, 0, 0]).")
            .allowedBy(onlyOf("attenuation", LightKind::point, "a point"))
            .writtenIf(isOf(LightKind::point));
        f.add("intensity", &Light::intensity, numberIn(0, kMostIntensity), "0: the light is left out.");
        f.add("colour", &Light::colour, colourKind(), "Linear light.");
        f.add("shadow", &Light::shadow, trueOrFalse(), "It casts a shadow.");
        f.add("softness", &Light::softness, numberIn(0, kMostSoftness),
              "The light's diameter as seen from what it lights, degrees.");
        return f;
    }();
    return fields;
}

const Fields<Occlusion>& occlusionFields() {
    static const Fields<Occlusion> fields = [] {
        Fields<Occlusion> f("occlusion",
                            "Ambient occlusion: how much of the light from all sides reaches a place.");
        f.add(
            "method", &Occlusion::method, named<OcclusionMethod>(),
            "What of a ray's way counts. local: each part by the light that is left there; positional: what "
            "is left at its end; rejecting: the same, where only what grows denser along the ray takes "
            "light.");
        f.add("rays", &Occlusion::rays,
              wholeIn(kRays.front(), kRays.back())
                  .checked([](int rays, const JsonValue& value) {
                      if (std::find(kRays.begin(), kRays.end(), rays) == kRays.end())
                          value.refuse("one of 4, 8, 16, 20, 32, 64, 80, 128, 320, 512");
                  })
                  .described({{"enum", kRays}}),
              "Directions that are looked into.");
        f.add("radius", &Occlusion::radiusMm, numberIn(kAboveZero, 1e4), "How far rays look, mm.");
        f.add("offset", &Occlusion::offsetMm, numberIn(0, 1e3), "Where they begin, mm.");
        f.add("bias", &Occlusion::bias, numberIn(0, 1),
              "Ambient light is (bias + what is open)^gamma of all: more bias, less dark.");
        f.add("gamma", &Occlusion::gamma, numberIn(kAboveZero, 8), "More gamma, deeper folds.");
        f.add("emission", &Occlusion::emission, numberIn(0, 100),
              "How strongly materials with an emission light what is around them; 0: not at all. With method "
              "local only.");
        return f;
    }();
    return fields;
}

const Fields<SurfaceOcclusion>& surfaceOcclusionFields() {
    static const Fields<SurfaceOcclusion> fields = [] {
        Fields<SurfaceOcclusion> f("surfaceOcclusion",
                                   "Ambient occlusion of isosurfaces, from what rays of a still meet first. "
                                   "Where isosurfaces are all that shows; takes the place of occlusion.");
        f.add("rays", &SurfaceOcclusion::rays, wholeIn(1, SurfaceOcclusion::kMostRays),
              "Directions that every place looks into.");
        f.add("radius", &SurfaceOcclusion::radiusMm, numberIn(1e-3, 1e4), "How far they look, mm.");
        f.add("filter", &SurfaceOcclusion::filter, trueOrFalse(),
              "Places side by side share what they found, along edges and not across.");
        return f;
    }();
    return fields;
}

} // namespace

const Fields<Shading>& shadingFields() {
    static const Fields<Shading> fields = [] {
        Fields<Shading> f("shading", "How what is shown answers to light.");
        f.add("shade", &Shading::on, trueOrFalse(), "false: colours as the transfer function has them.");
        f.add("ambient", &Shading::ambient, numberIn(0, 1), "Light from all sides.");
        f.add("diffuse", &Shading::diffuse, numberIn(0, 1), "Light that is scattered.");
        f.add("specular", &Shading::specular, numberIn(0, 1), "Highlights.");
        f.add("specularPower", &Shading::specularPower, numberIn(0, 1024),
              "The higher, the smaller they are.");
        f.add(
            "gradient", &Shading::gradient, named<Gradient>(),
            "How the field's gradient is taken: differences to one side, over a pitch to both, smoothed, the "
            "derivative of trilinear interpolation, over half a pitch to both sides, or that of the cubic "
            "B-spline.");
        f.add("model", &Shading::model, named<ShadingModel>(),
              "What highlights follow: the mirrored light, or the direction halfway between light and viewer "
              "(wider at the same power).")
            .unlessDefault();
        f.add("gradientWeight", &Shading::gradientWeight,
              numbersAt<GradientWeight>(&GradientWeight::low, &GradientWeight::high)
                  .checked([](const GradientWeight& weight, const JsonValue& value) {
                      if (!(weight.low >= 0 && weight.low <= weight.high))
                          value.refuse("[low, high], 0 or more, ascending");
                      checkValue(weight.high, "[low, high]", value.place());
                  }),
              "[low, high], physical units per mm: gradients up to low make no surface, light is that of a "
              "volume there; from high on they do. Without it every gradient does.");
        return f;
    }();
    return fields;
}

const Fields<Lighting>& lightingFields() {
    static const Fields<Lighting> fields = [] {
        Fields<Lighting> f("lighting", "Where light comes from, and what of it gets where.");
        const std::string most = std::to_string(Lighting::kMaxLights);
        f.add("lights", &Lighting::lights,
              listOf(objectOf(lightFields()), 1, Lighting::kMaxLights,
                     "1 to " + most + " lights (without the key: a head light)"),
              "Without it: one white head light of intensity 1.")
            .unlessDefault();
        f.add("occlusion", &Lighting::occlusion, objectOf(occlusionFields()));
        f.add("surfaceOcclusion", &Lighting::surfaceOcclusion, objectOf(surfaceOcclusionFields()));
        f.add("finestLevel", &Lighting::finestLevel, wholeIn(0, 3),
              "Of the light that is kept of voxels: 0: of every sample; 1: one for 2^3 voxels, interpolated; "
              "and so on.")
            .unlessDefault();
        f.rule([](const JsonValue& whole, const Lighting& lighting) {
            const int ambient = ambientChannels(lighting);
            if (lightChannels(lighting) > kMostLightChannels)
                whole.refuse("at most " + std::to_string(kMostLightChannels - ambient) +
                             (ambient > 1 ? " light with a shadow beside occlusion with emission"
                                          : " lights with shadows beside occlusion"));
        });
        return f;
    }();
    return fields;
}

} // namespace tessera
