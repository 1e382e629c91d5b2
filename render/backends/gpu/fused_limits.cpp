// render/backends/gpu/fused_limits.cpp: what a device needs for several volumes in one pass; see
// gpu_engine.h.
#include "core/scene/lighting.h"
#include "render/backends/gpu/gpu_engine.h"

#include <algorithm>
#include <epoxy/gl.h>

namespace tessera {

FuseLimits fuseLimits() {
    FuseLimits limits;
    glGetIntegerv(GL_MAX_COMPUTE_TEXTURE_IMAGE_UNITS, &limits.textures);
    glGetIntegerv(GL_MAX_COMBINED_TEXTURE_IMAGE_UNITS, &limits.units);
    glGetIntegerv(GL_MAX_COMPUTE_UNIFORM_COMPONENTS, &limits.components);
    return limits;
}

std::string cannotFuse(const Scene& scene, const FuseLimits& limits) {
    const auto volumes = static_cast<int>(scene.volumes.size());
    if (volumes < 2)
        return {};
    // Values, index, empty space, function; two of mixed levels. Shaders have an array of each for all
    // volumes.
    constexpr int kTextures = 6, kOfLight = 2, kOfLabels = 4;
    // Counted as if each vector took four: matrices, levels, function; lights, materials, gradient opacity.
    constexpr int kComponents = 360, kOfRays = 128, kOfSlab = 12;
    const bool labels = std::any_of(scene.volumes.begin(), scene.volumes.end(),
                                    [](const SceneVolume& volume) { return !volume.labels.path.empty(); });
    const auto needs = [&](int needed, int allowed, const char* what) {
        return needed <= allowed
                   ? std::string()
                   : "the scene's " + std::to_string(volumes) + " volumes need " + std::to_string(needed) +
                         " " + what + ", and this device allows " + std::to_string(allowed);
    };
    std::size_t slabs = 0;
    for (const SceneVolume& volume : scene.volumes)
        slabs += 3 * volume.cuts.boxes.size() + volume.cuts.planes.size();
    const int textures = volumes * (kTextures + (keptLightChannels(scene.lighting) > 0 ? kOfLight : 0) +
                                    (labels ? kOfLabels : 0));
    std::string why = needs(textures, limits.textures, "textures in a shader");
    if (why.empty())
        why = needs(volumes * static_cast<int>(kMostUnits), limits.units, "texture units");
    if (why.empty())
        why = needs(volumes * kComponents + kOfRays + (slabs > 0 ? kMostCutSlabs * kOfSlab : 0),
                    limits.components, "numbers of uniforms");
    if (why.empty() && slabs > static_cast<std::size_t>(kMostCutSlabs))
        why = "the cuts of single volumes have " + std::to_string(slabs) + " sides, and shaders take " +
              std::to_string(kMostCutSlabs);
    return why;
}

} // namespace tessera
