// render/backends/gpu/features.cpp: see features.h.
#include "render/backends/gpu/features.h"

namespace tessera {

const std::vector<FeatureModule>& featureModules() {
    static const std::vector<FeatureModule> modules = [] {
        std::vector<FeatureModule> all = {
#define TESSERA_FEATURE(Name, name) features::name(),
            TESSERA_FEATURES(TESSERA_FEATURE)
#undef TESSERA_FEATURE
        };
        for (std::size_t i = 0; i < all.size(); ++i)
            all[i].bit = 1u << i;
        return all;
    }();
    return modules;
}

const std::vector<FeatureName>& featureNames() {
    static const std::vector<FeatureName> names = [] {
        std::vector<FeatureName> all;
        for (const FeatureModule& m : featureModules())
            all.push_back({static_cast<Feature>(m.bit), m.define, m.meaning});
        return all;
    }();
    return names;
}

std::uint32_t integratorFeatures(Integrator integrator) {
    switch (integrator) {
    case Integrator::linear:
        return kFeatureLinear;
    case Integrator::preintegrated:
        return kFeaturePreintegrated;
    case Integrator::preintegrated2d:
        return kFeaturePreintegrated | kFeaturePreintegration2d;
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
    case Gradient::sobel2:
    case Gradient::sobel4:
        return kFeatureSobelGradient;
    case Gradient::analytic:
        return kFeatureAnalyticGradient;
    case Gradient::centralHalf:
        return kFeatureHalfCentralGradient;
    case Gradient::cubic:
        return kFeatureCubicGradient;
    }
    return 0;
}

std::string featureDefines(std::uint32_t features, const std::vector<FeatureModule>& modules) {
    std::string text;
    for (const FeatureModule& m : modules)
        text += std::string("#define ") + m.define + ((features & m.bit) ? " 1\n" : " 0\n");
    return text;
}

} // namespace tessera
