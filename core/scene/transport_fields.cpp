// core/scene/transport_fields.cpp: the keys of light along paths, and of what sends it from all around: see
// light_fields.h.
#include "core/scene/light_fields.h"

namespace tessera {

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

} // namespace

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
        Fields<Environment> f("environment",
                              "Light from all around, for transport and for reflections of isosurfaces.");
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
                                    "light along paths (--light cinematic, daylight, rim) and reflections");
        f.add("intensity", &Environment::intensity, numberIn(0, kMostIntensity),
              "Brightness overhead; of a file, a factor.");
        f.add("colour", &Environment::colour, colourKind(), "Colour, linear light; of a file, a factor.");
        f.add("below", &Environment::below, colourKind(),
              "two-tone: colour from below; softboxes: of the right one.");
        f.add("up", &Environment::up,
              vectorWithin(-kFarthestLightMm, kFarthestLightMm, "[x, y, z]")
                  .checked([](const glm::dvec3& up, const JsonValue& value) {
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

} // namespace tessera
