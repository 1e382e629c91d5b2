// tests/support/scene_fixture.h: tools that the image tests share: stores in the build folder (made by
// prepare_test_stores, a fixture of ctest), scenes on them, and cameras, one of them inside.
#pragma once

#include "core/scene/scene.h"
#include "render/backends/gpu/gpu_engine.h"
#include "render/backends/gpu/march.h"
#include "render/backends/gpu/skipping_binding.h"
#include "render/backends/mirror/mirror.h"
#include "render/picture/picture.h"
#include "render/plan/planner.h"
#include "render/residency/texels.h"
#include "tests/support/folders.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <memory>
#include <optional>
#include <string>

namespace tessera::test {

/// Roomy budgets: budgets have tests of their own.
struct Budgets {
    MemoryBudget ram{"RAM", "--ram", std::size_t{1} << 30};
    MemoryBudget gpu{"GPU memory", "--gpu-memory", std::size_t{1} << 30};
};

/// Camera number 0: outside, perspective, oblique; 1: outside, parallel, a side; 2: inside, wide angle.
inline Camera cameraNumber(int number, const VolumeInfo& info, const glm::ivec2& size) {
    if (number == 1)
        return fitCamera(info, View::left, Projection::parallel, size);
    Camera camera = fitCamera(info, View::anterior, Projection::perspective, size);
    const glm::dvec3 centre = camera.focalPoint;
    const double distance = glm::length(camera.position - centre);
    camera.position = centre + distance * 0.8 * glm::normalize(glm::dvec3(0.4, -1, 0.35));
    if (number == 2) {
        const glm::dvec3 extent(info.extentVoxels);
        camera.position =
            glm::dvec3(info.patientFromVoxel * glm::dvec4(extent * glm::dvec3(0.53, 0.31, 0.45), 1));
        camera.focalPoint =
            glm::dvec3(info.patientFromVoxel * glm::dvec4(extent * glm::dvec3(0.2, 0.9, 0.7), 1));
        camera.viewAngle = 110;
    }
    return camera;
}

inline Scene sceneOn(const VolumeInfo& info, const std::string& preset, int camera, const glm::ivec2& size) {
    Scene scene;
    SceneVolume volume;
    volume.transferFunction = preset;
    scene.volumes = {volume};
    scene.imageSize = size;
    scene.camera = cameraNumber(camera, info, size);
    scene.quality.fetch = Fetch::exact;
    scene.quality.terminationTransmittance = 0;
    scene.quality.integrator = Integrator::midpoint; // the others are for the tests that name them
    return scene;
}

/// One prepared scene with everything that must outlive it.
struct Prepared {
    /// @param place  not null: where the volume lies, whatever its store says. Nothing that is stored depends
    ///     on it, so that one store serves for volumes of any spacing, shear and origin.
    Prepared(const std::string& store, const Scene& scene, bool culling = true, std::size_t gpuBytes = 0,
             const glm::dmat4* place = nullptr)
        : reader(storePath(store), budgets.ram) {
        if (place)
            const_cast<VolumeInfo&>(reader.info()).patientFromVoxel = *place;
        MemoryBudget small("GPU memory", "--gpu-memory", gpuBytes ? gpuBytes : std::size_t{1} << 30);
        p = planScene(scene, reader, TextureLimits{}, {budgets.ram, small, 0},
                      culling ? LevelChoice::oneForAll : LevelChoice::oneForAllNothingCulled);
    }
    Budgets budgets;
    StoreReader reader;
    Planner p;
};

/// A prepared scene's bricks on the device of the current context, all of its selection.
struct OnDevice {
    explicit OnDevice(Prepared& prepared) : engine(prepared.budgets.gpu, prepared.budgets.ram) {
        Planner& p = prepared.p;
        p.chosen.chooser.reset(); // the selection stays as it is
        p.chosen.atlasPages = std::max<std::size_t>(1, pagesFor(p.layer().selection.counts));
        loadBricks(engine, p, prepared.budgets.gpu, work);
    }
    GpuEngine engine;
    Work work;
};

/// Draws a prepared scene by the GPU ray caster on the software device; features beside those of the volume's
/// type are the caller's.
struct GpuPicture {
    Image image;
    Work work;
    std::size_t refinedCells = 0;
};
/// @param refine  also where it does not pay
inline GpuPicture marchOn(Prepared& prepared, std::uint32_t features, const Slicing& slicing = {},
                          bool refine = false) {
    Planner& p = prepared.p;
    MemoryBudget& gpu = prepared.budgets.gpu;
    if (texelFormat(p.info().type).normalised)
        features |= kFeatureNormalised;
    features |= kFeatureCounting;
    if (p.layer().mixed())
        features |= kFeatureMixed;
    OnDevice device(prepared);
    GpuPicture out;
    out.work = device.work;
    GpuCaster caster(p, device.engine, features, gpu);
    if (refine)
        out.refinedCells = refineSkipping(caster.march().skippingMap(), p.layer().occupancy, p.layer().table,
                                          p.layer().optics, features, p.info(), device.engine.field(), gpu);
    drawToTheEnd(caster, device.engine, p, slicing, out.work);
    out.image = caster.image();
    return out;
}

inline bool bitEqual(const Image& a, const Image& b) {
    return a.size == b.size &&
           std::memcmp(a.pixels.data(), b.pixels.data(), a.pixels.size() * sizeof(glm::vec4)) == 0;
}

} // namespace tessera::test
