// tests/bench/accuracy/scenes.cpp: see scenes.h.
#include "tests/bench/accuracy/scenes.h"

#include "bricking/import/importer.h"
#include "bricking/statistics/statistics.h"
#include "core/base/error.h"
#include "core/base/names.h"
#include "core/base/output_file.h"
#include "core/scene/preset.h"
#include "datasets/phantom.h"
#include "render/plan/frame_plan.h" // summarise
#include "tests/bench/lod/workbench.h"

#include <algorithm>
#include <cmath>

namespace tessera::accuracy {
namespace {

namespace fs = std::filesystem;

fs::path phantomStore(const fs::path& folder, const std::string& name, const glm::ivec3& extent,
                      std::size_t ramBytes) {
    const fs::path store = folder / (name + ".zarr");
    MemoryBudget ram("RAM", "--ram", ramBytes);
    ImportOptions options;
    options.durable = false;
    options.force = true;
    importToStore(*makePhantom(name, extent), store, ram, options);
    return store;
}

Scene sceneOn(const fs::path& store, TransferChoice function, View view, bool lit, int pixels) {
    Scene scene;
    scene.volumes = {{store, std::move(function)}};
    scene.camera = FittedView{view, Projection::perspective, Fit::volume};
    scene.shading.on = lit;
    scene.imageSize = glm::ivec2(pixels);
    scene.quality.automaticStep = true;
    return scene;
}

/// T4: one extinction inside the sphere, nothing outside: a step, and chords of every length.
TransferFunction uniformInside() {
    return TransferFunction::fromOpacity({{-1000, 0}, {0, 0}, {0, 0.02}, {1000, 0.02}},
                                         {{0, {0.9, 0.5, 0.2}}, {1000, {0.2, 0.5, 0.9}}}, 1);
}

/// T11: extinction k / (s + eps) over a ramp s in [0,3/4], eps = 1/1000, linear in opacity between points
/// that lie geometrically. Opacity is per a length so short that it does not saturate.
TransferFunction boundaryLayer(double lowest, double highest, double lengthMm) {
    constexpr double kEps = 1e-3, kStrength = 1, kPointsPerDecade = 8;
    // The layer begins inside: the volume's outermost half voxels are flat, and would be all that is seen.
    constexpr double kBegin = 0.25;
    const double unitMm = 1e-2 * kEps * lengthMm;
    const double begin = lowest + kBegin * (highest - lowest);
    std::vector<OpacityPoint> opacity = {{begin, 0}};
    for (int i = 0;; ++i) {
        const double s = std::min(1 - kBegin, kEps * (std::pow(10, i / kPointsPerDecade) - 1));
        const double extinction = kStrength / (lengthMm * (s + kEps));
        opacity.push_back({begin + (highest - lowest) * s, -std::expm1(-extinction * unitMm)});
        if (s == 1 - kBegin)
            break;
    }
    return TransferFunction::fromOpacity(std::move(opacity),
                                         {{begin, {1, 0.2, 0.1}}, {highest, {0.1, 0.4, 1}}}, unitMm);
}

/// A spike 1/4096 of the values' range wide, at the lowest value of bone; what it adds where it is crossed
/// does not depend on its width.
TransferFunction spike(double lowest, double highest) {
    const double width = (highest - lowest) / 4096, at = 250;
    return TransferFunction::fromOpacity({{at - width / 2, 0}, {at, 0.9}, {at + width / 2, 0}},
                                         {{at - 50, {0.9, 0.8, 0.6}}}, 0.01 * width);
}

fs::path copiedStore(const fs::path& store, const fs::path& copy) {
    std::error_code error;
    fs::copy(store, copy, fs::copy_options::recursive | fs::copy_options::overwrite_existing, error);
    if (error)
        throw Error(copy.string() + ": cannot be written: " + error.message());
    return copy;
}

ValueSummary valuesOf(const fs::path& store, std::size_t ramBytes) {
    MemoryBudget ram("RAM", "--ram", ramBytes);
    const StoreReader reader(store, ram);
    return summarise(loadStatistics(reader, ram, 0), reader.info());
}

} // namespace

std::vector<std::string> standardSceneNames() {
    return {"sphere",      "boundary-layer", "narrow-ct", "soft-tissue-ct", "soft-tissue-plain",
            "surfaces-ct", "sparse"};
}

StandardScenes standardScenes(const fs::path& folder, const fs::path& scans,
                              const std::vector<std::string>& only, bool quick, std::size_t ramBytes,
                              const CommonOptions& common, bool keep) {
    const std::vector<std::string> names = standardSceneNames();
    for (const std::string& name : only)
        indexOfName(name, names, "--only"); // throws for one that is not there
    StandardScenes made;
    const auto wanted = [&](const std::string& name) {
        const bool is = only.empty() || std::find(only.begin(), only.end(), name) != only.end();
        if (!is)
            made.leftOut.push_back("Scene `" + name + "`: not asked for.");
        return is;
    };
    const int pixels = quick ? 96 : 128; // all of them are compared
    if (wanted("sphere"))
        made.scenes.push_back({"sphere",
                               "A sphere of constant extinction (closed form T4), colour along its depth.",
                               sceneOn(phantomStore(folder, "sphere", glm::ivec3(quick ? 48 : 128), ramBytes),
                                       uniformInside(), View::anterior, false, pixels)});
    if (wanted("boundary-layer")) {
        const fs::path store = phantomStore(folder, "ramp", glm::ivec3(quick ? 48 : 128), ramBytes);
        const ValueSummary values = valuesOf(store, ramBytes);
        made.scenes.push_back(
            {"boundary-layer",
             "A stiff boundary layer (closed form T11): extinction k/(s+1/1000) over a ramp s, entered where "
             "it is dense.",
             sceneOn(store, boundaryLayer(values.lowest, values.highest, 256), View::right, false, pixels)});
    }
    const bool narrow = wanted("narrow-ct"), soft = wanted("soft-tissue-ct"),
               plain = wanted("soft-tissue-plain"), surfaces = wanted("surfaces-ct");
    if (narrow || soft || plain || surfaces) {
        const bench::Workbench scansBench =
            bench::makeWorkbench(EngineKind::automatic, "auto", scans, bench::VolumeSet::levels, {"abdomen"},
                                 folder, quick, ramBytes, common);
        if (scansBench.volumes.empty()) {
            for (const auto& [asked, name] :
                 {std::pair(narrow, "narrow-ct"), std::pair(soft, "soft-tissue-ct"),
                  std::pair(plain, "soft-tissue-plain"), std::pair(surfaces, "surfaces-ct")})
                if (asked)
                    made.leftOut.push_back(
                        "Scene `" + std::string(name) +
                        "`: the abdomen CT is not at hand (`--scans FOLDER` names where it is).");
        } else {
            bench::BenchVolume ct = scansBench.volumes.front();
            if (keep)
                ct.store = copiedStore(ct.store, folder / (ct.name + ".zarr"));
            const ValueSummary values = valuesOf(ct.store, ramBytes);
            if (narrow)
                made.scenes.push_back(
                    {"narrow-ct", "A spike of opacity 1/4096 of the range wide, on a " + ct.about + ".",
                     sceneOn(ct.store, spike(values.lowest, values.highest), View::anterior, false, pixels)});
            if (soft)
                made.scenes.push_back(
                    {"soft-tissue-ct", "Preset soft-tissue, lit, on a " + ct.about + ".",
                     sceneOn(ct.store, std::string("soft-tissue"), View::anterior, true, pixels)});
            if (plain)
                made.scenes.push_back(
                    {"soft-tissue-plain",
                     "Preset soft-tissue, not lit, on a " + ct.about +
                         ": the scan that other renderers can be compared on, which take other normals.",
                     sceneOn(ct.store, std::string("soft-tissue"), View::anterior, false, pixels)});
            if (surfaces) {
                NamedScene skinAndBone{"surfaces-ct",
                                       "Isosurfaces of skin, half seen through, and of bone, lit, and "
                                       "nothing of the volume, on a " +
                                           ct.about + ".",
                                       sceneOn(ct.store, TransferFunction::fromOpacity({{0, 0}}, {}, 1),
                                               View::anterior, true, pixels)};
                skinAndBone.scene.surfaces = {{-300, {0.85, 0.5, 0.38}, 0.3}, {220, {0.95, 0.9, 0.78}, 1}};
                made.scenes.push_back(std::move(skinAndBone));
            }
        }
    }
    if (wanted("sparse")) {
        const glm::ivec3 extent = quick ? glm::ivec3(256, 192, 300) : glm::ivec3(640, 480, 750);
        NamedScene sparse{
            "sparse",
            "Bone of a generated torso, most of it empty, in a GPU budget that its bricks do not fit.",
            sceneOn(phantomStore(folder, "torso", extent, ramBytes), std::string("bone-1"), View::anterior,
                    false, pixels)};
        sparse.gpuBytes = std::size_t{quick ? 12U : 32U} << 20;
        made.scenes.push_back(std::move(sparse));
    }
    return made;
}

void keepScenes(const std::vector<NamedScene>& scenes, const fs::path& folder, std::size_t ramBytes) {
    for (const NamedScene& scene : scenes) {
        Scene kept = scene.scene;
        SceneVolume& volume = kept.volumes.front();
        if (const auto* preset = std::get_if<std::string>(&volume.transferFunction))
            volume.transferFunction = presetFunction(*preset, valuesOf(volume.path, ramBytes));
        volume.path = volume.path.lexically_relative(folder);
        writeOutputFile(folder / (scene.name + ".json"), sceneJson(kept) + "\n");
    }
}

} // namespace tessera::accuracy
