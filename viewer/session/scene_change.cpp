// viewer/session/scene_change.cpp: see scene_change.h. Parts of scenes are compared as they are written.
#include "viewer/session/scene_change.h"

#include <algorithm>
#include <optional>
#include <string>
#include <variant>

namespace tessera {
namespace {

/// A scene without what a renderer can be told while it goes on.
/// @param compiles  as changeOf() has it
std::string fixedPart(Scene scene, bool compiles) {
    scene.measurements.clear();
    scene.window = std::string("auto");
    scene.lighting = {};
    scene.shading = {};
    if (!compiles)
        scene.cuts = {};
    scene.camera = FittedView{};
    for (SceneVolume& volume : scene.volumes) {
        volume.transferFunction = std::string();
        volume.opacity = 1;
        volume.labels = {}; // compared as they are: they may be thousands
    }
    scene.meshes.clear(); // the same
    return sceneJson(scene);
}

/// They look alike in pictures of a volume: all but how they lie over planes is the same.
bool lookAlike(const Labels& a, const Labels& b) {
    const auto inVolumes = [](Labels labels) {
        labels.fill.reset();
        labels.outline = Labels().outline;
        for (LabelRule& rule : labels.each)
            rule.fill = rule.outline = std::nullopt;
        return labels;
    };
    return a == b || inVolumes(a) == inVolumes(b);
}

std::string functionPart(const SceneVolume& volume) {
    Scene alone;
    alone.volumes = {{"v", volume.transferFunction}};
    return sceneJson(alone);
}

std::string lightPart(const Scene& scene) {
    Scene alone;
    alone.volumes = {{"v", std::string()}};
    alone.lighting = scene.lighting;
    alone.shading = scene.shading;
    return sceneJson(alone);
}

} // namespace

SceneChange changeOf(const Scene& wished, const Scene& drawn, const Camera& camera, bool compiles) {
    SceneChange change;
    change.another = wished.volumes.size() != drawn.volumes.size() || wished.meshes != drawn.meshes ||
                     fixedPart(wished, compiles) != fixedPart(drawn, compiles);
    for (std::size_t n = 0; n < std::min(wished.volumes.size(), drawn.volumes.size()); ++n) {
        const SceneVolume &a = wished.volumes[n], &b = drawn.volumes[n];
        change.another = change.another ||
                         !(wished.mode == Mode::slice ? a.labels == b.labels : lookAlike(a.labels, b.labels));
        if (functionPart(a) != functionPart(b))
            change.recoloured.push_back(n);
        if (a.opacity != b.opacity)
            change.faded.push_back(n);
    }
    const auto* const asked = std::get_if<Camera>(&wished.camera);
    change.turned = !asked || *asked != camera;
    change.rewindowed = wished.window != drawn.window;
    change.recut = !(wished.cuts == drawn.cuts);
    change.relit = lightPart(wished) != lightPart(drawn);
    return change;
}

} // namespace tessera
