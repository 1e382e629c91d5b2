// tests/support/surface_fixture.h: tools that the tests of isosurfaces share: formulas as stored volumes,
// scenes of surfaces on them, and pictures with what their rays hit.
#pragma once

#include "bricking/import/importer.h"
#include "core/base/program_folders.h"
#include "render/plan/planner.h"
#include "tests/support/formula_source.h"
#include "tests/support/scene_fixture.h"

#include <algorithm>
#include <memory>
#include <vector>

namespace tessera::test {

/// A stored formula, sheared and of unlike spacings, and scenes on it: white surfaces, nothing of the volume.
struct Stored {
    Stored(const Formula& value, const glm::ivec3& extent = glm::ivec3(44, 40, 48), bool plain = false,
           double slope = 1, ValueType type = ValueType::f32) {
        info.type = type;
        info.extentVoxels = extent;
        info.rescaleSlope = slope;
        info.patientFromVoxel =
            plain ? glm::dmat4(1) : patientFromVoxelOf({-30, 50, 7}, {0.8, 0, 0}, {0, 0.9, 0}, {0, 0.3, 1.5});
        MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20);
        FormulaSource source(info, value);
        ImportOptions options;
        options.force = true;
        importToStore(source, folder / "v.zarr", ram, options);
    }
    Scene scene(const std::vector<Isosurface>& surfaces, int camera = 0, int edge = 32) const {
        Scene s = sceneOn(info, "bone-1", camera, {edge, edge});
        s.volumes[0].path = folder / "v.zarr";
        s.volumes[0].transferFunction = TransferFunction::fromExtinction({}, {});
        s.surfaces = surfaces;
        return s;
    }
    std::unique_ptr<Prepared> prepare(const Scene& scene, bool culling = true) const {
        return std::make_unique<Prepared>((folder / "v").string(), scene, culling);
    }
    const ScratchFolder folder;
    VolumeInfo info;
};

/// Torso scenes: bone opaque, skin semi-transparent, with and without the volume.
inline Scene torsoScene(int camera, bool volume, Integrator integrator, const glm::ivec2& size = {24, 24}) {
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    const VolumeInfo info = StoreReader(storePath("torso"), ram).info();
    Scene scene = sceneOn(info, "soft-tissue", camera, size);
    if (!volume)
        scene.volumes[0].transferFunction = TransferFunction::fromExtinction({}, {});
    scene.quality.integrator = integrator;
    scene.surfaces = {{-300, {0.9, 0.6, 0.5}, 0.3}, {250, {0.95, 0.9, 0.8}, 1}};
    return scene;
}

/// A picture and what its rays hit.
struct Drawn {
    Image image;
    std::vector<SurfaceHit> hits;
    Work work;
};
/// By the GPU ray caster on the software device, with its rays' hits.
inline Drawn draw(Prepared& prepared, std::uint32_t without = 0, const Slicing& slicing = {},
                  bool refine = false) {
    Planner& p = prepared.p;
    MemoryBudget& gpu = prepared.budgets.gpu;
    const std::uint32_t features = (marchFeatures(p, true) | kFeatureHits) & ~without;
    OnDevice device(prepared);
    Drawn out;
    out.work = device.work;
    GpuCaster caster(p, device.engine, features, gpu);
    const auto refined = [&](const GlTexture3d& map, const Occupancy& occupancy, const TransferTable& table) {
        refineSkipping(map, occupancy, table, p.layer().optics, features, p.info(), device.engine.field(),
                       gpu);
    };
    if (refine)
        refined(caster.march().skippingMap(), p.layer().occupancy, p.layer().table);
    if (refine && p.layer().mapsSurfaces && (features & kFeatureSkipping) != 0)
        refined(caster.march().surfaceMap(), p.layer().surfaceOccupancy, p.layer().surfaceTable);
    drawToTheEnd(caster, device.engine, p, slicing, out.work);
    out.image = caster.image();
    out.hits = caster.hits();
    return out;
}

inline std::size_t hitCount(const std::vector<SurfaceHit>& hits) {
    return static_cast<std::size_t>(
        std::count_if(hits.begin(), hits.end(), [](const SurfaceHit& h) { return h.surface != 0; }));
}

} // namespace tessera::test
