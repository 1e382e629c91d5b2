// render/plan/label_optics.cpp: see label_optics.h.
#include "render/plan/label_optics.h"

#include "core/base/error.h"
#include "core/scene/mode.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace tessera {
namespace {

/// The rules that are the first with their function and material, from 1.
std::vector<std::size_t> opticsOf(const Labels& labels) {
    std::vector<std::size_t> found;
    for (std::size_t rule = 0; !labels.path.empty() && rule < labels.each.size(); ++rule)
        if (opticsOf(labels, rule) == rule + 1)
            found.push_back(rule + 1);
    return found;
}

} // namespace

bool hasLabelOptics(const Scene& scene) {
    if (reductionOf(scene) != Reduction::composite || scene.mode == Mode::isosurface)
        return false;
    for (const SceneVolume& volume : scene.volumes)
        if (!opticsOf(volume.labels).empty())
            return true;
    return false;
}

namespace {

/// The cuts of the first volume become those of the scene, but for boxes in its voxels.
void shareOwnCuts(Scene& scene) {
    Cuts& own = scene.volumes.front().cuts;
    const auto inPatient = std::stable_partition(own.boxes.begin(), own.boxes.end(), [](const CropBox& box) {
        return box.space == CropBox::Space::voxels;
    });
    scene.cuts.boxes.insert(scene.cuts.boxes.end(), inPatient, own.boxes.end());
    own.boxes.erase(inPatient, own.boxes.end());
    scene.cuts.planes.insert(scene.cuts.planes.end(), own.planes.begin(), own.planes.end());
    scene.cuts.scissors.insert(scene.cuts.scissors.end(), own.scissors.begin(), own.scissors.end());
    own.planes.clear();
    own.scissors.clear();
}

} // namespace

DrawnVolumes withLabelOptics(const Scene& scene, Stores stores) {
    TESSERA_CHECK(stores.size() == scene.volumes.size());
    DrawnVolumes drawn{scene, {stores.begin(), stores.end()}};
    if (!hasLabelOptics(scene))
        return drawn;
    if (scene.volumes.size() == 1) // exact, as of a volume that is alone
        shareOwnCuts(drawn.scene);
    const std::vector<SceneVolume> volumes = drawn.scene.volumes;
    for (std::size_t n = 0; n < volumes.size(); ++n) {
        drawn.scene.volumes[n].labels.optics = 0;
        for (const std::size_t optics : opticsOf(volumes[n].labels)) {
            SceneVolume volume = volumes[n];
            volume.labels.optics = optics;
            volume.labels.ofVolume = n;
            const LabelRule& rule = volume.labels.each[optics - 1];
            if (rule.transferFunction)
                volume.transferFunction = *rule.transferFunction;
            drawn.scene.volumes.push_back(std::move(volume));
            drawn.stores.push_back(stores[n]);
        }
    }
    if (scene.fusion != Fusion::mix)
        throw badFile("fusion", "mix with labels that have functions or materials of their own",
                      nameOf(scene.fusion));
    if (drawn.scene.volumes.size() > Scene::kMaxVolumes)
        throw badFile("volumes",
                      "at most " + std::to_string(Scene::kMaxVolumes) +
                          " in all: volumes, and different functions and materials of labels",
                      std::to_string(drawn.scene.volumes.size()));
    return drawn;
}

TransferFunction ofLabels(TransferFunction function, const Labels& labels, const ValueSummary& values) {
    const std::size_t optics = labels.optics.value_or(0);
    if (optics == 0 || !labels.each.at(optics - 1).material)
        return function;
    const MaterialResponse& own = *labels.each[optics - 1].material;
    const double beyond = 1 + std::abs(values.lowest) + std::abs(values.highest);
    function.setMaterials({{values.lowest - beyond, values.highest + beyond, own.ambient, own.diffuse,
                            own.specular, own.specularPower}});
    return function;
}

} // namespace tessera
