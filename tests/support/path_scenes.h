// tests/support/path_scenes.h: scenes with paths of light, of the torso and its labels, and their pictures.
#pragma once

#include "core/base/error.h"
#include "render/picture/render_scene.h"
#include "tests/support/graded.h"
#include "tests/support/labelled.h"
#include "tests/support/mixed_fixture.h"
#include "tests/support/native_fixture.h"
#include "tests/support/surface_fixture.h"

#include <cstddef>
#include <gtest/gtest.h>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace tessera::test::path_scenes {

inline Light sun(double softness = 8) {
    Light light;
    light.kind = LightKind::directional;
    light.direction = {0.5, 0.7, 0.6};
    light.softness = softness;
    return light;
}

inline Transport physical(int bounces, const Phase& phase = {}) {
    return {TransportResponse::physical, bounces, phase, {}};
}

inline Scene lit(Scene scene, int bounces = 4) {
    scene.lighting.lights = {sun()};
    scene.lighting.transport = physical(bounces, {PhaseKind::henyeyGreenstein, 0.3});
    scene.lighting.environment = Environment{Sky::twoTone, 0.5};
    scene.quality.pixels = {4, PixelFilter::box, 3};
    return scene;
}

/// Light from all around by a file, as if it had been read: a dim sky with a sun.
inline Scene underFile(Scene scene) {
    std::vector<glm::vec3> texels(128 * 64, glm::vec3(0.2f, 0.3f, 0.5f));
    texels[20 * 128 + 70] = glm::vec3(900, 800, 500);
    Environment& sky = scene.lighting.environment.emplace();
    sky.file = {"sky.exr", std::make_shared<const EnvironmentMap>(glm::ivec2(128, 64), std::move(texels))};
    sky.rotation = 20;
    return scene;
}

inline RenderResult drawn(const Scene& scene, const StoreReader& store, MemoryBudget& ram, EngineKind engine,
                          int threads = 2, std::size_t gpuBytes = std::size_t{256} << 20) {
    MemoryBudget gpu("GPU memory", "--gpu-memory", gpuBytes);
    RenderOptions options;
    options.engine = engine;
    options.threads = threads;
    RenderResult result = renderScene(scene, store, ram, gpu, options);
    EXPECT_LE(ram.peakBytes(), ram.limitBytes());
    EXPECT_LE(gpu.peakBytes(), gpu.limitBytes());
    EXPECT_EQ(result.work.paths.exceeded, 0u);
    return result;
}

struct Torso {
    Torso() : reader(storePath("torso"), ram) {}
    Scene scene(const std::string& preset, int camera = 0, glm::ivec2 size = {32, 24}) const {
        return sceneOn(reader.info(), preset, camera, size);
    }
    RenderResult draw(const Scene& scene, EngineKind engine, int threads = 2,
                      std::size_t gpuBytes = std::size_t{256} << 20) {
        return drawn(scene, reader, ram, engine, threads, gpuBytes);
    }
    MemoryBudget ram{"RAM", "--ram", std::size_t{256} << 20};
    StoreReader reader;
};

/// Labels of every look, some of them hidden, gradient opacity and media of labels.
inline Scene labelledScene(const Torso& torso, const BallsOfLabels& labels, LabelLook look, bool grades) {
    Scene scene = lit(torso.scene("soft-tissue", 1));
    if (grades)
        grade(scene);
    label(scene, labels.store, look);
    scene.volumes[0].labels.hide = {"two"};
    scene.volumes[0].labels.each = {{"40", LabelLook::plain, 0.5, {}},
                                    {"3", LabelLook::tint, {}, glm::dvec3(0, 1, 0)},
                                    {"7", LabelLook::solid, 0.05, {}}};
    return scene;
}

/// Cut by what rays are clipped to, and by what leaves several parts of them.
inline Scene cutScene(const Torso& torso, const BallsOfLabels& labels, bool parts) {
    Scene scene = labelledScene(torso, labels, LabelLook::solid, true);
    const glm::dvec3 extent(torso.reader.info().extentVoxels);
    scene.cuts.boxes = {{0.1 * extent, 0.8 * extent, CropBox::Space::voxels, Keep::inside}};
    const glm::dvec3 middle(torso.reader.info().patientFromVoxel * glm::dvec4(0.5 * extent, 1));
    scene.cuts.planes = {{middle, {0.2, 1, 0.3}, Keep::inside}};
    scene.lighting.transport->surface = SurfaceScattering{{20, 150}, 0.1, 0.3};
    if (parts) {
        scene.cuts.boxes.push_back({0.4 * extent, 0.6 * extent, CropBox::Space::voxels, Keep::outside});
        scene.cuts.scissors = {
            {std::get<Camera>(scene.camera), 4.0 / 3, {{0.2, 0.2}, {0.7, 0.4}, {0.4, 0.9}}, Keep::outside}};
    }
    return scene;
}

/// Lamps in tissue and at the eye, tissue that glows, Rayleigh's function, and nothing around.
inline Scene lampsInTissue(const Torso& torso) {
    Scene scene = lit(torso.scene("bone-1"), 3);
    auto function = TransferFunction::fromExtinction({{-300, 0}, {200, 0.03}, {1500, 0.3}},
                                                     {{-300, {0.9, 0.3, 0.2}}, {800, {0.9, 0.9, 0.7}}});
    function.setMaterials({{250, 900, 0.3, 0.7, 0.2, 20, {0.2, 0.05, 0}}});
    function.setTissues({{200, 600, Phase{PhaseKind::schlick, 0.5}, SurfaceFinish{0.2, 0.2}}});
    scene.volumes[0].transferFunction = function;
    Light lamp;
    lamp.kind = LightKind::point;
    lamp.frame = LightFrame::patient;
    const glm::dvec3 extent(torso.reader.info().extentVoxels);
    lamp.position =
        glm::dvec3(torso.reader.info().patientFromVoxel * glm::dvec4(extent * glm::dvec3(0.5, 0.3, 0.5), 1));
    lamp.attenuation = {1, 0.01, 0.001};
    scene.lighting.lights = {Light{}, lamp};
    scene.lighting.environment.reset();
    scene.lighting.transport->phase = {PhaseKind::rayleigh};
    scene.lighting.transport->surface = SurfaceScattering{{20, 150}, {}};
    scene.lighting.transport->colours = TransportColours::reflectance;
    return scene;
}

inline std::vector<Scene> manyScenes(const Torso& torso, const BallsOfLabels& labels) {
    std::vector<Scene> scenes;
    for (int camera = 0; camera < 3; ++camera)
        scenes.push_back(lit(torso.scene(camera == 1 ? "soft-tissue" : "bone-1", camera)));
    scenes.push_back(lit(torso.scene("lung")));
    grade(scenes.back());
    scenes.push_back(lit(torso.scene("bone-1")));
    label(scenes.back(), labels.store);
    scenes.push_back(labelledScene(torso, labels, LabelLook::tint, true));
    scenes.push_back(labelledScene(torso, labels, LabelLook::plain, false));
    scenes.back().volumes[0].labels.show = {"group:pair", "5", "6", "7"};
    scenes.push_back(cutScene(torso, labels, false));
    scenes.push_back(cutScene(torso, labels, true));
    scenes.push_back(lit(torso.scene("bone-1"), 1));
    scenes.back().quality.skipping = false;
    scenes.push_back(lit(torso.scene("soft-tissue")));
    scenes.back().lighting.transport->surface = SurfaceScattering{{20, 150}, 0.1, 0.3};
    scenes.push_back(lit(torso.scene("soft-tissue", 1)));
    scenes.back().lighting.transport->surface = SurfaceScattering{{10, 60}, {0.1, 0.3, 0.6, 12}};
    scenes.push_back(lit(torso.scene("skin")));
    Light lamp;
    lamp.kind = LightKind::point;
    lamp.position = {10, 20, 30};
    lamp.attenuation = {1, 0.01, 0.001};
    scenes.back().lighting.lights = {Light{}, lamp};
    scenes.back().lighting.transport->phase = {PhaseKind::rayleigh};
    scenes.push_back(underFile(lit(torso.scene("soft-tissue", 2))));
    scenes.back().lighting.transport->surface = SurfaceScattering{{20, 150}, 0.1, 0.3};
    scenes.push_back(underFile(cutScene(torso, labels, true)));
    scenes.push_back(lit(torso.scene("bone-1")));
    scenes.back().lighting.environment->sky = Sky::softboxes;
    scenes.push_back(cutScene(torso, labels, false));
    scenes.back().lighting.transport->normals = ScatteringNormals::sobel;
    for (const PathPreview preview : {PathPreview::few, PathPreview::squared}) {
        scenes.push_back(cutScene(torso, labels, true));
        scenes.back().lighting.transport->preview = preview;
    }
    return scenes;
}

/// The message of a refused scene, or "drawn".
inline std::string refused(const Scene& scene, EngineKind engine = EngineKind::native) {
    Torso torso;
    try {
        torso.draw(scene, engine);
    } catch (const InputError& e) {
        return e.what();
    }
    return "drawn";
}

} // namespace tessera::test::path_scenes
