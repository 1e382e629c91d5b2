// tests/support/splat_scene.h: volumes that are formulas, drawn by splats.
#pragma once

#include "bricking/import/importer.h"
#include "core/base/program_folders.h"
#include "render/backends/splat/splat_renderer.h"
#include "render/plan/planner.h"
#include "tests/support/formula_source.h"
#include "tests/support/scene_fixture.h"

#include <cmath>
#include <filesystem>
#include <memory>
#include <vector>

namespace tessera::test {

/// A store, and pictures of it.
struct SplatScene {
    Budgets budgets;
    ScratchFolder folder;
    std::unique_ptr<StoreReader> store;
    Scene scene;
    SplatReport report;

    SplatScene(const glm::ivec3& extent, const Formula& value, const glm::dmat4& place = glm::dmat4(1)) {
        VolumeInfo info;
        info.extentVoxels = extent;
        info.type = ValueType::f32;
        info.patientFromVoxel = place;
        FormulaSource source(info, value);
        importToStore(source, folder / "v.zarr", budgets.ram, {});
        open(folder / "v.zarr", {96, 80});
        scene.camera = cameraNumber(1, store->info(), scene.imageSize);
        scene.shading.on = false;
    }
    SplatScene(const std::filesystem::path& path, const glm::ivec2& size) { open(path, size); }
    void open(const std::filesystem::path& path, const glm::ivec2& size) {
        store = std::make_unique<StoreReader>(path, budgets.ram);
        scene = sceneOn(store->info(), "bone-1", 0, size);
        scene.quality.fetch = Quality().fetch; // of rays, as the integrator is: those of splats are none
        scene.quality.integrator = Quality().integrator;
    }
    void show(const std::vector<OpacityPoint>& extinction, const std::vector<ColourPoint>& colours = {}) {
        scene.volumes[0].transferFunction = TransferFunction::fromExtinction(extinction, colours);
    }
    Planner plan() {
        return planScene(scene, *store, TextureLimits{}, {budgets.ram, budgets.gpu, 0},
                         LevelChoice::oneForAll);
    }
    Image draw(Planner& p, const SplatSettings& settings = {}, int threads = 2, MemoryBudget* gpu = nullptr) {
        EngineInput input;
        input.threads = threads;
        SplatRenderer renderer(input, settings);
        const FrameContext context(budgets.ram, gpu ? *gpu : budgets.gpu, threads);
        const RenderOptions options;
        RenderResult result;
        Image added;
        renderer.draw({scene, p, context, options}, result, added);
        report = renderer.report();
        return result.image;
    }
    Image draw(const SplatSettings& settings = {}) {
        Planner p = plan();
        return draw(p, settings);
    }
};

/// The sum of a picture's optical depths.
inline double depthOf(const Image& image) {
    double sum = 0;
    for (const glm::vec4& pixel : image.pixels)
        sum -= std::log1p(-double{pixel.a});
    return sum;
}
inline double rmsOf(const Image& a, const Image& b) {
    double sum = 0;
    for (std::size_t n = 0; n < a.pixels.size(); ++n) {
        const glm::dvec4 d(a.pixels[n] - b.pixels[n]);
        sum += glm::dot(d, d) / 4;
    }
    return std::sqrt(sum / static_cast<double>(a.pixels.size()));
}

} // namespace tessera::test
