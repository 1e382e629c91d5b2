// core/scene/occlusion_fields.cpp: the keys of occlusion and of what shadow maps keep: see light_fields.h.
#include "core/scene/light_fields.h"

#include <algorithm>
#include <array>

namespace tessera {

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

namespace {

/// Numbers of corners or faces of subdivided platonic solids.
constexpr std::array kRays = {4, 8, 16, 20, 32, 64, 80, 128, 320, 512};

const Fields<DirectionWeights>& directionWeightFields() {
    static const Fields<DirectionWeights> fields = [] {
        Fields<DirectionWeights> f("weights",
                                   "Directions that count more among occlusion rays: ambient light "
                                   "that comes from one side rather than evenly from all.");
        f.add("towards", &DirectionWeights::towards,
              vectorWithin(-kFarthestLightMm, kFarthestLightMm, "[x, y, z]")
                  .checked([](const glm::dvec3& d, const JsonValue& value) {
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

} // namespace

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
        f.add("radius", &Occlusion::radiusMm, numberIn(1e-6, 1e4),
              "Length of the rays, mm; of histogram the radius of the ball around.");
        f.add("offset", &Occlusion::offsetMm, numberIn(0, 1e3),
              "Distance at which rays begin, mm; not of histogram.");
        f.add("bias", &Occlusion::bias, numberIn(0, 1),
              "Share of ambient light = (bias + unoccluded share)^gamma: more bias, less dark.");
        f.add("gamma", &Occlusion::gamma, numberIn(1e-6, 8),
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

} // namespace tessera
