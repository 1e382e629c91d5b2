// tests/support/fused.h: scenes of several volumes in one place: a body of i16, a hot spot of f32 on a grid
// of its own, turned and coarser, and a third of u16 that reaches beyond the first.
#pragma once

#include "bricking/import/importer.h"
#include "core/base/program_folders.h"
#include "render/exposure/exposed_caster.h"
#include "render/light/scene_light.h"
#include "render/picture/render_scene.h"
#include "render/plan/fusion.h"
#include "tests/support/bricking_test_volumes.h"
#include "tests/support/formula_source.h"
#include "tests/support/native_fixture.h"
#include "tests/support/scene_fixture.h"

#include <cmath>
#include <filesystem>
#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

namespace tessera::test {

/// A value at a place in patient space, mm.
using FieldMm = std::function<double(const glm::dvec3&)>;

/// A grid whose middle is at a place, turned about an oblique axis.
inline VolumeInfo gridAt(const glm::dvec3& middle, const glm::ivec3& extent, const glm::dvec3& spacing,
                         double degrees, ValueType type) {
    VolumeInfo info;
    info.type = type;
    info.extentVoxels = extent;
    glm::dmat4 m = glm::rotate(glm::dmat4(1), glm::radians(degrees), glm::dvec3(0.3, -0.2, 1));
    for (int axis = 0; axis < 3; ++axis)
        m[axis] = m[axis] * spacing[axis];
    m[3] = glm::dvec4(middle - glm::dvec3(m * glm::dvec4(0.5 * glm::dvec3(extent), 0)), 1);
    info.patientFromVoxel = m;
    return info;
}

/// Stores of fields, made once for a program.
class FieldStores {
  public:
    std::filesystem::path store(const VolumeInfo& info, const FieldMm& field) {
        const auto path = folder_ / ("v" + std::to_string(number_++) + ".zarr");
        MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20);
        const auto value = [&](const glm::dvec3& voxel) {
            return field(glm::dvec3(info.patientFromVoxel * glm::dvec4(voxel, 1)));
        };
        if (info.type == ValueType::u16 || info.type == ValueType::u8) {
            HashSource source(
                info, [&](int x, int y, int z) { return std::round(value(glm::dvec3(x, y, z) + 0.5)); });
            importToStore(source, path, ram, {});
        } else {
            FormulaSource source(info, value);
            importToStore(source, path, ram, {});
        }
        return path;
    }

  private:
    ScratchFolder folder_;
    int number_ = 0;
};

inline double ripples(const glm::dvec3& p) {
    return 200 + 160 * std::sin(0.21 * p.x + 1) * std::cos(0.17 * p.y) * std::sin(0.13 * p.z + 0.5);
}
inline double blob(const glm::dvec3& p, const glm::dvec3& at, double mm) {
    return std::exp(-glm::dot(p - at, p - at) / (2 * mm * mm));
}
/// The places of the hot spots, patient space, mm.
inline const std::vector<glm::dvec3>& spots() {
    static const std::vector<glm::dvec3> all = {{-14, 6, 9}, {15, -12, -4}, {3, 14, -17}};
    return all;
}
inline double hot(const glm::dvec3& p) {
    double sum = 0;
    for (const glm::dvec3& spot : spots())
        sum += 10 * blob(p, spot, 5);
    return sum;
}

/// The three volumes.
inline const std::vector<std::filesystem::path>& fusedStores() {
    static FieldStores stores;
    static const std::vector<std::filesystem::path> all = {
        stores.store(gridAt({0, 0, 0}, {140, 132, 144}, {0.45, 0.5, 0.4}, 0, ValueType::i16), ripples),
        stores.store(gridAt({1, 2, -1}, {26, 22, 24}, {2.6, 3, 2.8}, 25, ValueType::f32), hot),
        stores.store(
            gridAt({30, 4, 3}, {100, 98, 104}, {0.6, 0.55, 0.6}, -40, ValueType::u16),
            [](const glm::dvec3& p) { return 1000 + 900 * std::sin(0.2 * p.x) * std::cos(0.3 * p.z); })};
    return all;
}

/// A scene of some of them, by number.
inline Scene fusedScene(const std::vector<int>& numbers, const glm::ivec2& size) {
    const TransferFunction functions[] = {
        TransferFunction::fromOpacity({{150, 0}, {260, 0.05}, {330, 0.3}}, {{150, {0.9, 0.6, 0.4}}}, 1),
        TransferFunction::fromOpacity({{2, 0}, {6, 0.2}, {9, 0.5}}, {{2, {1, 0.2, 0}}, {9, {1, 1, 0.2}}}, 2),
        TransferFunction::fromOpacity({{1500, 0}, {1600, 0.15}}, {{0, {0.2, 0.5, 1}}}, 1.5)};
    Scene scene;
    for (const int n : numbers) {
        SceneVolume volume;
        volume.path = fusedStores()[static_cast<std::size_t>(n)];
        volume.transferFunction = functions[n];
        scene.volumes.push_back(volume);
    }
    scene.imageSize = size;
    Camera camera;
    camera.position = {60, -150, 70};
    camera.focalPoint = {4, 0, 0};
    camera.viewUp = {0, 0, 1};
    camera.viewAngle = 30;
    scene.camera = camera;
    scene.quality.fetch = Fetch::exact;
    scene.quality.terminationTransmittance = 0;
    scene.quality.integrator = Integrator::midpoint;
    scene.quality.stepVoxels = 0.5;
    return scene;
}

/// With one light that casts shadows.
inline Scene shadowed(Scene scene) {
    Light key;
    key.kind = LightKind::directional;
    key.direction = {0.3, 0.8, 0.5};
    key.shadow = true;
    scene.lighting.lights = {key};
    return scene;
}

/// A parallel camera along y, towards the origin.
inline Camera frontCamera(double parallelScale) {
    Camera camera;
    camera.projection = Projection::parallel;
    camera.position = {0, -100, 0}, camera.focalPoint = {0, 0, 0}, camera.viewUp = {0, 0, 1};
    camera.parallelScale = parallelScale;
    return camera;
}

/// Two even media in one box, of extinctions per mm, looked at along y.
struct TwoMedia {
    static constexpr double kMm = 20, kFirst = 0.03, kSecond = 0.05, kUnit = 4;
    FieldStores stores;
    Scene scene;
    TwoMedia() {
        const auto path = stores.store(gridAt({0, 0, 0}, {20, 20, 20}, {1, 1, 1}, 0, ValueType::f32),
                                       [](const glm::dvec3&) { return 1.0; });
        SceneVolume first;
        first.path = path;
        first.transferFunction = TransferFunction::fromOpacity(
            {{0, -std::expm1(-kFirst * kUnit)}, {2, -std::expm1(-kFirst * kUnit)}}, {{0, {1, 0.2, 0}}},
            kUnit);
        SceneVolume second = first;
        second.transferFunction = TransferFunction::fromOpacity(
            {{0, -std::expm1(-kSecond * kUnit)}, {2, -std::expm1(-kSecond * kUnit)}}, {{0, {0, 0.6, 1}}},
            kUnit);
        scene.volumes = {first, second};
        scene.camera = frontCamera(2);
        scene.imageSize = {4, 4};
        scene.shading.on = false;
        scene.quality.terminationTransmittance = 0;
    }
};

/// Opened, with the budgets.
struct OpenedVolumes {
    explicit OpenedVolumes(const Scene& scene) {
        for (const SceneVolume& volume : scene.volumes) {
            readers.push_back(std::make_unique<StoreReader>(volume.path, budgets.ram, volume.transform));
            stores.push_back(readers.back().get());
        }
    }
    Budgets budgets;
    std::vector<std::unique_ptr<StoreReader>> readers;
    std::vector<const StoreReader*> stores;
};

/// A plan of several volumes, all at their finest levels.
struct PreparedFusion : OpenedVolumes {
    explicit PreparedFusion(const Scene& scene)
        : OpenedVolumes(scene), p(planScene(scene, stores, TextureLimits{}, {budgets.ram, budgets.gpu, 0},
                                            LevelChoice::oneForAll, kPictureBytesPerPixel)) {}
    std::vector<Planner*> plans() {
        std::vector<Planner*> all = {&p};
        for (const auto& volume : p.further)
            all.push_back(&volume->plan);
        return all;
    }
    Planner p;
};

inline Image nativePicture(PreparedFusion& prepared, const NativeChoices& choices = {}) {
    Budgets& budgets = prepared.budgets;
    NativeEngine engine(choices.threads, budgets.gpu, budgets.ram);
    for (Planner* plan : prepared.plans()) {
        plan->layer().pageEdge = choices.ghostLayers ? kGhostedEdge : kBrickExtent;
        plan->chosen.chooser.reset();
        plan->chosen.atlasPages = std::max<std::size_t>(1, pagesFor(plan->layer().selection.counts));
    }
    Work work;
    loadBricks(engine, prepared.p, budgets.gpu, work);
    NativeCaster caster(prepared.p, engine, {true, false, false}, budgets.gpu, choices.target);
    caster.begin(choices.rays.value_or(raysOf(prepared.p)));
    drawToTheEnd(caster, engine, prepared.p, choices.slicing, work);
    return caster.image();
}

/// Light of voxels of all volumes, where there is any: each shades the others.
struct FusedLight {
    explicit FusedLight(PreparedFusion& prepared) {
        if (lightChannels(prepared.p.view.lighting) == 0)
            return;
        for (Planner* plan : prepared.plans()) {
            lights.push_back(std::make_unique<SceneLight>(*plan, 0));
            lights.back()->ready();
        }
        for (const auto& light : lights) {
            std::vector<SceneLight*> others;
            for (const auto& other : lights)
                if (other != light)
                    others.push_back(other.get());
            light->shadedBy(others);
        }
        for (std::size_t n = 0; n < lights.size(); ++n)
            stored.push_back(
                std::make_unique<StoredLight>(*lights[n], *prepared.plans()[n], prepared.budgets.ram));
    }
    std::vector<std::unique_ptr<SceneLight>> lights;
    std::vector<std::unique_ptr<StoredLight>> stored;
};

/// By the float mirror, on given rays.
inline Image mirrorPicture(PreparedFusion& prepared, const std::vector<SegmentedRay<float>>& rays) {
    const FramePlan& p = prepared.p;
    const FusedLight light(prepared);
    MirrorInput input = mirrorInput(p, p.view.quality.skipping);
    for (std::size_t n = 0; n < light.stored.size(); ++n)
        (n == 0 ? input : input.further[n - 1]).light = light.stored[n].get();
    std::optional<CutRays> cuts;
    if (p.view.frame.cuts)
        input.cuts = &cuts.emplace(cutRays(p.view.frame, {}, 0));
    input.segmentVoxels = p.view.frame.segmentVoxels;
    Image image(p.view.imageSize);
    Work work;
    image.pixels = mirrorRays<float>(
        input, rays.size(), [&](std::size_t i) { return rays[i]; }, 0, work);
    return image;
}

/// The bricks of a plan on the device of the current context, and a caster for them and the plan's meshes.
struct FusedOnDevice {
    /// @param pages  of each volume at most; fewer than it has: rays wait
    explicit FusedOnDevice(PreparedFusion& prepared, std::size_t pages = SIZE_MAX)
        : plan(prepared.p), engine(prepared.budgets.gpu, prepared.budgets.ram) {
        MemoryBudget& gpu = prepared.budgets.gpu;
        for (Planner* one : prepared.plans()) {
            one->chosen.chooser.reset();
            one->chosen.atlasPages =
                std::min(pages, std::max<std::size_t>(1, pagesFor(one->layer().selection.counts)));
        }
        const bool waits = loadBricks(engine, prepared.p, gpu, work);
        caster = casterOf(engine, prepared.p, {true, false, waits}, gpu, 0);
        caster->begin(raysOf(plan));
    }
    Image picture(const Slicing& slicing = {}) {
        caster->begin(raysOf(plan));
        drawToTheEnd(*caster, engine, plan, slicing, work);
        return caster->image();
    }
    const Planner& plan;
    GpuEngine engine;
    Work work;
    std::unique_ptr<RayCaster> caster;
};

/// By the GPU ray caster on the context that is current, cut in each of these ways.
inline std::vector<Image> gpuPictures(PreparedFusion& prepared, const std::vector<Slicing>& cuts = {{}}) {
    FusedOnDevice device(prepared);
    std::vector<Image> pictures;
    for (const Slicing& slicing : cuts)
        pictures.push_back(device.picture(slicing));
    EXPECT_GT(device.work.samples, 0u);
    return pictures;
}

/// By renderScene(), which keeps within its budgets.
inline RenderResult fusedPicture(const Scene& scene, EngineKind engine,
                                 std::size_t gpuBytes = std::size_t{1} << 30,
                                 std::size_t ramBytes = std::size_t{1} << 30,
                                 LevelChoice levels = LevelChoice::perBrick) {
    OpenedVolumes opened(scene);
    MemoryBudget ram("RAM", "--ram", ramBytes), gpu("GPU memory", "--gpu-memory", gpuBytes);
    RenderOptions options;
    options.engine = engine;
    options.levels = levels;
    options.device.text = "software";
    RenderResult result = renderScene(scene, opened.stores, ram, gpu, options);
    EXPECT_LE(ram.peakBytes(), ramBytes);
    EXPECT_LE(gpu.peakBytes(), gpuBytes);
    return result;
}

} // namespace tessera::test
