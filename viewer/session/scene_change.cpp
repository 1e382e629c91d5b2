// viewer/session/scene_change.cpp: see scene_change.h. Parts of scenes are compared as they are written.
#include "viewer/session/scene_change.h"

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
    scene.volumes.front().transferFunction = std::string();
    scene.volumes.front().labels = {}; // compared as they are: they may be thousands
    scene.meshes.clear();              // the same
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

std::string functionPart(const Scene& scene) {
    Scene alone;
    alone.volumes = {{"v", scene.volumes.front().transferFunction}};
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
    const Labels &wishedLabels = wished.volumes.front().labels, &drawnLabels = drawn.volumes.front().labels;
    change.another =
        !(wished.mode == Mode::slice ? wishedLabels == drawnLabels : lookAlike(wishedLabels, drawnLabels)) ||
        wished.meshes != drawn.meshes || fixedPart(wished, compiles) != fixedPart(drawn, compiles);
    const auto* const asked = std::get_if<Camera>(&wished.camera);
    change.turned = !asked || *asked != camera;
    change.recoloured = functionPart(wished) != functionPart(drawn);
    change.rewindowed = wished.window != drawn.window;
    change.recut = !(wished.cuts == drawn.cuts);
    change.relit = lightPart(wished) != lightPart(drawn);
    return change;
}

} // namespace tessera
