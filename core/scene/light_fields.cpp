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
                                                   {OcclusionMethod::rejecting, "rejecting"},
                                                   {OcclusionMethod::histogram, "histogram"}}};
    return names;
}

template <> const NameTable<OcclusionDirections>& namesOf() {
    static const NameTable<OcclusionDirections> names{
        {{OcclusionDirections::sphere, "sphere"}, {OcclusionDirections::hemisphere, "hemisphere"}}};
    return names;
}
template <> const NameTable<ShadowMapKind>& namesOf() {
    static const NameTable<ShadowMapKind> names{{{ShadowMapKind::deep, "deep"},
                                                 {ShadowMapKind::first, "first"},
                                                 {ShadowMapKind::variance, "variance"}}};
    return names;
}

template <> const NameTable<ReflectionKind>& namesOf() {
    static const NameTable<ReflectionKind> names{{{ReflectionKind::constant, "constant"},
                                                  {ReflectionKind::fresnel, "fresnel"},
                                                  {ReflectionKind::gradient, "gradient"}}};
    return names;
}

template <> const NameTable<ScatterSource>& namesOf() {
    static const NameTable<ScatterSource> names{{ScatterSource::rays, "rays"}, {ScatterSource::map, "map"}};
    return names;
}

template <> const NameTable<PhaseKind>& namesOf() {
    static const NameTable<PhaseKind> names{{{PhaseKind::henyeyGreenstein, "henyey-greenstein"},
                                             {PhaseKind::schlick, "schlick"},
                                             {PhaseKind::rayleigh, "rayleigh"}}};
    return names;
}
template <> const NameTable<TransportResponse>& namesOf() {
    static const NameTable<TransportResponse> names{
        {{TransportResponse::physical, "physical"}, {TransportResponse::contract, "contract"}}};
    return names;
}
template <> const NameTable<TransportColours>& namesOf() {
    static const NameTable<TransportColours> names{
        {{TransportColours::albedo, "albedo"}, {TransportColours::reflectance, "reflectance"}}};
    return names;
}
template <> const NameTable<ScatteringNormals>& namesOf() {
    static const NameTable<ScatteringNormals> names{{ScatteringNormals::shading, "shading"},
                                                    {ScatteringNormals::sobel, "sobel"}};
    return names;
}
template <> const NameTable<PathPreview>& namesOf() {
    static const NameTable<PathPreview> names{
        {{PathPreview::none, "none"}, {PathPreview::few, "few"}, {PathPreview::squared, "squared"}}};
    return names;
}
template <> const NameTable<Sky>& namesOf() {
    static const NameTable<Sky> names{{{Sky::uniform, "uniform"},
                                       {Sky::overcast, "overcast"},
                                       {Sky::twoTone, "two-tone"},
                                       {Sky::softboxes, "softboxes"}}};
    return names;
}

namespace {

constexpr double kMostMm = 1e7, kMostIntensity = 1e6, kMostSoftness = 60;
/// At the light itself; a lower attenuation would overflow.
constexpr double kLeastAttenuation = 1e-6, kMostAttenuation = 1e6;
/// Numbers of corners or faces of subdivided platonic solids.
constexpr std::array kRays = {4, 8, 16, 20, 32, 64, 80, 128, 320, 512};
constexpr double kAboveZero = 1e-6;

Kind<glm::dvec3> within(double lowest, double highest, const std::string& expected) {
    return numbersWithin<glm::dvec3>(lowest, highest, expected, &glm::dvec3::x, &glm::dvec3::y,
                                     &glm::dvec3::z);
}

Kind<GradientWeight> gradientWeightKind() {
    return numbersAt<GradientWeight>(&GradientWeight::low, &GradientWeight::high)
        .checked([](const GradientWeight& weight, const JsonValue& value) {
            if (!(weight.low >= 0 && weight.low <= weight.high))
                value.refuse("[low, high], 0 or more, ascending");
            checkValue(weight.high, "[low, high]", value.place());
        });
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
        f.add("direction", &Light::direction, within(-kMostMm, kMostMm, "[x, y, z]"),
              "Directional lights only: towards the light, of any length (default: [0, 0, 1]). [0, 0, 0] "
              "lights only what is shaded as a volume.")
            .allowedBy(onlyOf("direction", LightKind::directional, "a directional"))
            .writtenIf(isOf(LightKind::directional));
        f.add("position", &Light::position, within(-kMostMm, kMostMm, "[x, y, z], mm"),
              "Point lights only: position, mm (default: [0, 0, 0]).")
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

const Fields<DirectionWeights>& directionWeightFields() {
    static const Fields<DirectionWeights> fields = [] {
        Fields<DirectionWeights> f("weights",
                                   "Directions that count more among occlusion rays: ambient light "
                                   "that comes from one side rather than evenly from all.");
        f.add("towards", &DirectionWeights::towards,
              within(-kMostMm, kMostMm, "[x, y, z]").checked([](const glm::dvec3& d, const JsonValue& value) {
                  if (d == glm::dvec3(0))
                      value.refuse("a direction other than [0, 0, 0]");
              }),
              "Where that light comes from, LPS, of any length.");
        f.add("strength", &DirectionWeights::strength, numberIn(0, 1000),
              "A direction weighs 1 + strength times its cosine with that one, where that is above 0.");
        return f;
    }();
    return fields;
}

const Fields<Occlusion>& occlusionFields() {
    static const Fields<Occlusion> fields = [] {
        Fields<Occlusion> f("occlusion",
                            "Ambient occlusion: the share of ambient light that reaches a point.");
        f.add("method", &Occlusion::method, named<OcclusionMethod>(),
              "Weight of an occlusion ray. local: each part counts by the light that is left there. "
              "positional: the light left at its end. rejecting: as positional, but only tissue that grows "
              "denser along the ray takes light. histogram: without rays, by the values around; whole light "
              "follows an edit of the transfer function at once, and is blurrier.");
        f.add("rays", &Occlusion::rays,
              wholeIn(kRays.front(), kRays.back())
                  .checked([](int rays, const JsonValue& value) {
                      if (std::find(kRays.begin(), kRays.end(), rays) == kRays.end())
                          value.refuse("one of 4, 8, 16, 20, 32, 64, 80, 128, 320, 512");
                  })
                  .described({{"enum", kRays}}),
              "Number of occlusion rays; not of histogram.");
        f.add("radius", &Occlusion::radiusMm, numberIn(kAboveZero, 1e4),
              "Length of the rays, mm; of histogram the radius of the ball around.");
        f.add("offset", &Occlusion::offsetMm, numberIn(0, 1e3),
              "Distance at which rays begin, mm; not of histogram.");
        f.add("bias", &Occlusion::bias, numberIn(0, 1),
              "Share of ambient light = (bias + unoccluded share)^gamma: more bias, less dark.");
        f.add("gamma", &Occlusion::gamma, numberIn(kAboveZero, 8),
              "Exponent of that share: more gamma, darker folds.");
        f.add("emission", &Occlusion::emission, numberIn(0, 100),
              "Factor on the light that emissive materials cast on their surroundings; 0: none. With method "
              "local only.");
        f.add("bleeding", &Occlusion::bleeding, numberIn(0, 1),
              "Factor on the colours that tissue around a place adds to its ambient light; 0: none. With "
              "method histogram only.")
            .unlessDefault();
        f.add("weights", &Occlusion::weights, objectOf(directionWeightFields()));
        f.add(
             "directions", &Occlusion::directions, named<OcclusionDirections>(),
             "Where rays go. sphere: to all sides alike. hemisphere: where tissue has a surface, weighted by "
             "the cosine with its normal, so that what lies behind a surface does not darken it.")
            .unlessDefault();
        return f;
    }();
    return fields;
}

const Fields<SurfaceOcclusion>& surfaceOcclusionFields() {
    static const Fields<SurfaceOcclusion> fields = [] {
        Fields<SurfaceOcclusion> f("surfaceOcclusion",
                                   "Ambient occlusion of isosurfaces and meshes, at the first hits of a "
                                   "still's rays. Where there are isosurfaces it replaces occlusion: the "
                                   "volume itself has none.");
        f.add("rays", &SurfaceOcclusion::rays, wholeIn(1, SurfaceOcclusion::kMostRays),
              "Number of rays of each surface point.");
        f.add("radius", &SurfaceOcclusion::radiusMm, numberIn(1e-3, 1e4), "Their length, mm.");
        f.add("filter", &SurfaceOcclusion::filter, trueOrFalse(),
              "Results of neighbouring points are averaged, along edges and not across.");
        f.add("scale", &SurfaceOcclusion::scale,
              wholeIn(1, 4)
                  .checked([](int scale, const JsonValue& value) {
                      if (scale == 3)
                          value.refuse("one of 1, 2, 4");
                  })
                  .described({{"enum", {1, 2, 4}}}),
              "Rays start at every pixel, or at one of 2x2 or 4x4, between which results are interpolated "
              "along edges. Above 1 with filter only.")
            .unlessDefault();
        f.add("resolution", &SurfaceOcclusion::resolution,
              wholeIn(SurfaceOcclusion::kLeastResolution, SurfaceOcclusion::kMostResolution),
              "Voxels into which meshes are cut for these rays, along the longest side of their box.")
            .unlessDefault();
        f.add("threshold", &SurfaceOcclusion::threshold, numberIn(0.2, 0.8),
              "Share of these voxels around a place from which on it is inside a mesh: less, darker.")
            .unlessDefault();
        return f;
    }();
    return fields;
}

const Fields<ShadowMapping>& shadowMappingFields() {
    static const Fields<ShadowMapping> fields = [] {
        Fields<ShadowMapping> f("shadowMap", "What shadow maps keep of a light's rays.");
        f.add("kind", &ShadowMapping::kind, named<ShadowMapKind>(),
              "deep: the light left at every depth. first: where light first meets something, behind which "
              "all is dark; a sixteenth of the memory. variance: the mean of such places around and of their "
              "squares, for softer edges; three sixteenths.");
        f.add("threshold", &ShadowMapping::threshold, numberIn(0.001, 0.999),
              "Opacity along a ray of light that counts as something; not of deep.");
        f.add("filter", &ShadowMapping::filter, wholeIn(0, ShadowMapping::kMostFilter),
              "Softens edges: how many of the map's rays to either side count; not of deep.");
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

const Fields<Phase>& phaseFields() {
    static const Fields<Phase> fields = [] {
        Fields<Phase> f("phase", "How a medium scatters light to all sides, by the angle of its way.");
        f.add("kind", &Phase::kind, named<PhaseKind>(),
              "Henyey and Greenstein's function, Schlick's, which is near it, or Rayleigh's.");
        f.add("g", &Phase::g, numberIn(-Phase::kMostG, Phase::kMostG),
              "Mean cosine: 0: evenly to all sides; above: onwards; below: back. Not of rayleigh.");
        f.add("backG", &Phase::backG, numberIn(-Phase::kMostG, Phase::kMostG),
              "henyey-greenstein: mean cosine of a second lobe.");
        f.add("backShare", &Phase::backShare, numberIn(0, 1), "henyey-greenstein: share of the second lobe.");
        return f;
    }();
    return fields;
}

namespace {

/// @param finish  from an object to its finish
template <typename T, typename Finish> void addFinish(Fields<T>& f, Finish finish) {
    const auto add = [&](const char* key, double SurfaceFinish::*number, double lowest, double highest,
                         const char* about) -> Field<T>& {
        return f.add(
            key, [=](auto& object) -> auto& { return finish(object).*number; }, numberIn(lowest, highest),
            about);
    };
    add("mirrored", &SurfaceFinish::mirrored, 0, 1,
        "Share of light that the coat mirrors at right angles; 0: no coat.");
    add("roughness", &SurfaceFinish::roughness, 0.05, 1, "Roughness of the coat.");
    add("translucent", &SurfaceFinish::translucent, 0, 1,
        "Share of the light below the coat that goes through the surface, in a lobe around the straight way; "
        "the rest is scattered evenly.")
        .unlessDefault();
    add("translucentPower", &SurfaceFinish::translucentPower, 0, SurfaceFinish::kMostPower,
        "Exponent of that lobe: the higher, the clearer what is behind; 0: evenly to the other side.")
        .unlessDefault();
}

const Fields<SurfaceScattering>& surfaceScatteringFields() {
    static const Fields<SurfaceScattering> fields = [] {
        Fields<SurfaceScattering> f("surface",
                                    "Where the field is steep, light is scattered as by a surface: evenly, "
                                    "below a coat that mirrors. Without it tissue is a medium everywhere.");
        f.add(
             "gradient", &SurfaceScattering::gradient, gradientWeightKind(),
             "[low, high], physical units per mm: gradients up to low scatter as a medium, from high on as a "
             "surface.")
            .required();
        addFinish(
            f, [](auto& surface) -> auto& { return surface.finish; });
        return f;
    }();
    return fields;
}

const Fields<Transport>& transportFields() {
    static const Fields<Transport> fields = [] {
        Fields<Transport> f("transport",
                            "Light follows paths through the volume, which scatters it. Colours are shares "
                            "of light that is scattered; all lights cast shadows, and shading, occlusion and "
                            "finestLevel have no effect (response physical).");
        f.add(
            "response", &Transport::response, named<TransportResponse>(),
            "physical: light is scattered as in nature. contract: light, shadows and local occlusion as "
            "without transport, but for what maps and light per voxel cost; the other keys, and environment, "
            "are physical's.");
        f.add("bounces", &Transport::bounces, wholeIn(1, Transport::kMostBounces),
              "Scatterings of a path, at most.");
        f.add("phase", &Transport::phase, objectOf(phaseFields())).unlessDefault();
        f.add("surface", &Transport::surface, objectOf(surfaceScatteringFields()));
        f.add("colours", &Transport::colours, named<TransportColours>(),
              "What colours are where tissue scatters as a medium. albedo: the share of light that one "
              "scattering leaves. reflectance: what a thick layer of it shows under a white sky, so that "
              "tissue is as bright as its colour.")
            .unlessDefault();
        f.add("preview", &Transport::preview, named<PathPreview>(),
              "Light with a bias, in less time. few: from the third scattering on tissue takes light and "
              "scatters none. squared: light of the second scattering comes as if by a way like that between "
              "the first and it, from all around, and there is no third.")
            .unlessDefault();
        f.add("normals", &Transport::normals, named<ScatteringNormals>(),
              "Gradients by which surfaces scatter. shading: those of shading.gradient (of sobel-2 and "
              "sobel-4 sobel). sobel: smooth ones, "
              "so "
              "that noise and the lattice do not show on skin; opacity by gradient keeps those of shading.")
            .unlessDefault();
        return f;
    }();
    return fields;
}

const Fields<Environment>& environmentFields() {
    static const Fields<Environment> fields = [] {
        Fields<Environment> f("environment", "Light from all around, for transport.");
        f.add("sky", &Environment::sky, named<Sky>(),
              "uniform: the same from everywhere; overcast: from above, three times as much overhead as from "
              "the horizon; two-tone: from above and from below; softboxes: from two squares, above the left "
              "and the right of the front.");
        f.add(
             "file", [](auto& e) -> auto& { return e.file.path; }, anyText(),
             "In place of sky: the path of a picture of all directions, OpenEXR or Radiance (.hdr), relative "
             "to the scene's file. Its columns are longitudes, the middle one is the front; its rows are "
             "latitudes; it is twice as wide as high, 4096x2048 pixels at most.")
            .unlessDefault()
            .withoutDefault()
            .setBy("--environment", "light from all around by a picture of all directions (.exr, .hdr), for "
                                    "light along paths (--light cinematic, daylight, rim)");
        f.add("intensity", &Environment::intensity, numberIn(0, kMostIntensity),
              "Brightness overhead; of a file, a factor.");
        f.add("colour", &Environment::colour, colourKind(), "Colour, linear light; of a file, a factor.");
        f.add("below", &Environment::below, colourKind(),
              "two-tone: colour from below; softboxes: of the right one.");
        f.add(
            "up", &Environment::up,
            within(-kMostMm, kMostMm, "[x, y, z]").checked([](const glm::dvec3& up, const JsonValue& value) {
                if (up == glm::dvec3(0))
                    value.refuse("a direction, not [0, 0, 0]");
            }),
            "Towards its top, in its frame, of any length.");
        f.add("rotation", &Environment::rotation, numberIn(-360, 360),
              "Turns it about up, degrees, anticlockwise as seen from above.")
            .unlessDefault();
        f.add("frame", &Environment::frame, named<LightFrame>(),
              "Frame of up and of the front. patient: LPS; the front is anterior. camera: x to the picture's "
              "right, y up, z towards the viewer, who is in front where up is [0, 1, 0].")
            .unlessDefault();
        return f;
    }();
    return fields;
}

} // namespace

const Fields<SurfaceFinish>& finishFields() {
    static const Fields<SurfaceFinish> fields = [] {
        Fields<SurfaceFinish> f("finish", "How the surface answers light along paths, in place of "
                                          "lighting.transport.surface.");
        addFinish(
            f, [](auto& finish) -> auto& { return finish; });
        return f;
    }();
    return fields;
}

const Fields<Shading>& shadingFields() {
    static const Fields<Shading> fields = [] {
        Fields<Shading> f("shading", "Material response to light, and the gradient operator.");
        f.add("shade", &Shading::on, trueOrFalse(), "false: colours of the transfer function, unlit.")
            .setBy("--no-shading", "draw the transfer function's colours, unlit");
        f.add("ambient", &Shading::ambient, numberIn(0, 1), "Share of ambient light.");
        f.add("diffuse", &Shading::diffuse, numberIn(0, 1), "Share of diffuse light.");
        f.add("specular", &Shading::specular, numberIn(0, 1), "Share of specular light.");
        f.add("specularPower", &Shading::specularPower, numberIn(0, 1024),
              "Exponent of the highlights: the higher, the smaller they are.");
        f.add(
             "gradient", &Shading::gradient, named<Gradient>(),
             "Gradient operator: differences forward, central over a pitch or half a pitch to both sides, or "
             "of Sobel, or Sobel's over two or four pitches, for normals of noisy scans; or the derivative "
             "of "
             "trilinear interpolation (analytic) or of the cubic B-spline.")
            .setBy("--gradient", "gradient operator of shading: {names} (default: {default})");
        f.add("model", &Shading::model, named<ShadingModel>(),
              "Highlights by the mirrored light direction, or by the direction halfway between light and "
              "viewer (wider at the same power).")
            .unlessDefault();
        f.add("gradientWeight", &Shading::gradientWeight, gradientWeightKind(),
              "[low, high], physical units per mm: gradients up to low are shaded as a volume, from high on "
              "as a surface. Without it every gradient is a surface.");
        return f;
    }();
    return fields;
}

const Fields<Reflection>& reflectionFields() {
    static const Fields<Reflection> fields = [] {
        Fields<Reflection> f("reflection",
                             "The isosurface mirrors what is around it, in stills. What rays see beyond the "
                             "volume is lighting.environment, or the background.");
        f.add("kind", &Reflection::kind, named<ReflectionKind>(),
              "The share of light that is mirrored. constant: the same everywhere. fresnel: by the angle, as "
              "glass or water. gradient: by the length of the field's gradient.");
        f.add("strength", &Reflection::strength, numberIn(0, 1), "Factor on that share.");
        f.add("gradient", &Reflection::gradient, gradientWeightKind(),
              "[low, high], physical units per mm, of kind gradient: nothing is mirrored up to low, all from "
              "high on.")
            .unlessDefault();
        f.add("ior", &Reflection::ior, numberIn(1, Reflection::kMostIor),
              "Index of refraction behind the surface; before it that of the next lower isosurface, 1 below "
              "all.");
        f.add("transmits", &Reflection::transmits, trueOrFalse(),
              "Light that is not mirrored goes through the surface, refracted; by 1 less its opacity.")
            .unlessDefault();
        return f;
    }();
    return fields;
}

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
        f.add("scatterRadius", &Lighting::scatterRadiusMm, numberIn(kAboveZero, 1e4),
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
