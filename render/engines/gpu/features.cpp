// render/engines/gpu/features.cpp: see features.h.
#include "render/engines/gpu/features.h"

namespace tessera {

const std::vector<FeatureName>& featureNames() {
    static const std::vector<FeatureName> names = {
        {kFeatureShading, "FEATURE_SHADING", "Phong shading with a head light"},
        {kFeatureSkipping, "FEATURE_SKIPPING", "empty-space skipping"},
        {kFeatureHardware, "FEATURE_HARDWARE", "hardware-filtered fetches"},
        {kFeatureNormalised, "FEATURE_NORMALISED", "16-bit voxels"},
        {kFeatureTermination, "FEATURE_TERMINATION", "early ray termination"},
        {kFeatureCounting, "FEATURE_COUNTING", "work counters"},
        {kFeatureMixed, "FEATURE_MIXED", "interblock interpolation"},
        {kFeaturePasses, "FEATURE_PASSES", "several passes"},
        {kFeatureVisibility, "FEATURE_VISIBILITY", "counting of what is seen"},
        {kFeatureLinear, "FEATURE_LINEAR", "segments of linear colour"},
        {kFeaturePreintegrated, "FEATURE_PREINTEGRATED", "pre-integrated segments"},
        {kFeatureSeenColours, "FEATURE_SEENCOLOURS", "pre-integrated colours with attenuation"},
        {kFeatureForwardGradient, "FEATURE_FORWARD_GRADIENT", "gradients by forward differences"},
        {kFeatureSobelGradient, "FEATURE_SOBEL_GRADIENT", "gradients by smoothed differences (Sobel)"},
        {kFeatureAnalyticGradient, "FEATURE_ANALYTIC_GRADIENT", "gradients of the interpolation itself"},
        {kFeatureSurfaces, "FEATURE_SURFACES", "isosurfaces"},
        {kFeatureHits, "FEATURE_HITS", "what rays hit first"},
        {kFeatureHalfCentralGradient, "FEATURE_HALF_CENTRAL_GRADIENT", "gradients over one pitch"},
    };
    return names;
}

std::uint32_t integratorFeatures(Integrator integrator) {
    switch (integrator) {
    case Integrator::linear:
        return kFeatureLinear;
    case Integrator::preintegrated:
        return kFeaturePreintegrated;
    case Integrator::preintegrated2d:
        return kFeaturePreintegrated | kFeatureSeenColours;
    default:
        return 0;
    }
}

std::uint32_t gradientFeature(Gradient gradient) {
    switch (gradient) {
    case Gradient::forward:
        return kFeatureForwardGradient;
    case Gradient::central:
        break;
    case Gradient::sobel:
        return kFeatureSobelGradient;
    case Gradient::analytic:
        return kFeatureAnalyticGradient;
    case Gradient::centralHalf:
        return kFeatureHalfCentralGradient;
    }
    return 0;
}

std::string featureDefines(std::uint32_t features) {
    std::string text;
    for (const FeatureName& f : featureNames())
        text += std::string("#define ") + f.define + ((features & f.bit) ? " 1\n" : " 0\n");
    return text;
}

} // namespace tessera
