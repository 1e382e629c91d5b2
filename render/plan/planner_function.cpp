// render/plan/planner_function.cpp: what a plan makes of a transfer function, an integrator and light: see
// planner.h.
#include "core/base/error.h"
#include "core/base/magnitude.h"
#include "render/plan/choose_integrator.h"
#include "render/plan/layer_histograms.h"
#include "render/plan/planner.h"
#include "render/plan/planner_light.h"
#include "render/plan/scene_rules.h"

#include <algorithm>
#include <cmath>

namespace tessera {
namespace {

/// An integrator that was not requested uses tables only if they are a small part of the free memory.
constexpr std::size_t kPartsForTables = 16;

} // namespace

void Planner::setFunction(const TransferFunction& f, const Scene& scene) {
    const Reduction reduction = reductionOf(scene);
    const bool sums = reduction == Reduction::sum;
    layer().function = f;
    layer().addsUp = sums;
    layer().body = {};
    layer().function.setShare(sums ? 1 : scene.volumes.at(0).opacity);
    revisions.function = revisions.tables = PlanRevisions::next();
    if (reduction != Reduction::composite && !sums) {
        setValues(scene, reduction);
        return;
    }
    if (sums)
        exposeSums(scene);
    if (scene.mode == Mode::isosurface) { // the material response stays the function's
        layer().function = TransferFunction::fromOpacity({}, f.colourPoints(), f.referenceLengthMm());
        layer().function.setMaterials(f.materials());
    }
    std::vector<SurfaceValue> surfaces;
    for (const Isosurface& surface : scene.surfaces)
        if (surface.drawnOpacity() > 0)
            surfaces.push_back({surface.value, glm::vec3(surface.drawnColour()), surface.drawnOpacity()});
    layer().table = makeTable(layer().function, std::move(surfaces));
    const Integrator integrator =
        scene.quality.integrator == Integrator::automatic ? automaticIntegrator() : scene.quality.integrator;
    chargeTables(integrator);
    Preintegration2d seen = std::move(layer().optics.seen); // may be kept
    layer().optics =
        makeOptics(layer().table, info(), scene.shading, scene.quality.terminationTransmittance, integrator);
    layer().optics.seen = std::move(seen);
    layer().optics.surfaces = surfaceLooks(scene.surfaces, info());
    if (reflects(scene) && !scene.lighting.surfaceOcclusion)
        for (SurfaceLook& look : layer().optics.surfaces)
            look.reports = look.reflection.has_value();
    if (sums) {
        for (glm::vec4& entry : layer().optics.table)
            entry.a *= Exposure::kThin;
        layer().function.setShare(Exposure::kThin); // the reference reads its points
    }
    if (layer().labels)
        layer().optics.labels = layer().labels->numbers();
    setLighting(layer().optics, scene.shading, view.lighting, f.materials(), view.camera, info());
    if (!layer().selection.levels.empty())
        prepareSegments();
}

bool Planner::takesLight(const Scene& scene) const {
    const auto bytes = [&](const Lighting& lighting) { return lightBytes(*this, lighting); };
    const Shading& shading = scene.shading;
    return !layer().reduces() && shading.on == layer().optics.shading &&
           shading.gradient == layer().optics.normals &&
           ambientChannels(scene.lighting) == ambientChannels(view.lighting) &&
           lightChannels(scene.lighting) == lightChannels(view.lighting) &&
           bytes(scene.lighting) <= bytes(view.lighting) && hasHistograms(scene, layer());
}

bool Planner::setLight(const Scene& scene) {
    if (!takesLight(scene))
        return false;
    const Shading& shading = scene.shading;
    checkLight(scene);
    revisions.function = revisions.tables = PlanRevisions::next();
    view.lighting = scene.lighting;
    view.shading = shading;
    view.lighting.surfaceOcclusion.reset();
    view.lighting.transport.reset();
    setShading(layer().optics, shading);
    setLighting(layer().optics, shading, view.lighting, layer().function.materials(), view.camera, info());
    return true;
}

void Planner::setValues(const Scene& scene, Reduction reduction) {
    const ValueSummary values = summarise(layer().statistics, info(), scene.volumes.at(0).unit);
    layer().look = {scene.valueColour, windowOf(scene.window, values, scene.mode)};
    layer().table = valueTable(layer().look, layer().function, reduction);
    chargeTables(Integrator::midpoint);
    Shading unlit;
    unlit.on = false;
    layer().optics = makeOptics(layer().table, info(), unlit, 0, Integrator::midpoint);
    layer().optics.reduction = reduction;
}

/// Rays show sums of the function's extinctions, or of a radiograph's.
void Planner::exposeSums(const Scene& scene) {
    view.exposure = exposureOf(scene.mode, scene.valueColour, scene.window);
    setExposure(view.exposure->window);
    if (scene.mode != Mode::radiograph)
        return;
    const SceneVolume& volume = scene.volumes.at(0);
    const ValueSummary values = summarise(layer().statistics, info(), volume.unit);
    if (!values.isHu && !looksLikeHu(values))
        throw badFile(layer().store->path().string() + ", mode radiograph",
                      "a volume in HU (--unit HU says that it is)",
                      "values from " + shownNumber(values.lowest) + " to " + shownNumber(values.highest));
    layer().function = radiographFunction(values.highest);
    layer().body = makeTable(bodyFunction());
}

void Planner::setExposure(const std::optional<GreyWindow>& window) {
    view.exposure->window = window;
    layer().look.window = window.value_or(GreyWindow());
}

void Planner::chargeTables(Integrator integrator) {
    layer().functionCharge = {};
    layer().functionCharge = ram->charge(tableRamBytes(layer().table.entries.size(), integrator),
                                         "the transfer function's tables");
}

void Planner::settleIntegrator(const FrameContext& context, std::size_t mostEntries) {
    mayTake = Integrator::midpoint;
    // A path's first place is sought in lanes by the midpoint rule, and costs little beside the path.
    if (view.quality.edgeFunction == EdgeFunction::nearest || view.lighting.transport)
        return;
    for (const Integrator larger : {Integrator::preintegrated, Integrator::preintegrated2d})
        if (!(larger == Integrator::preintegrated2d && view.quality.sampling == Sampling::hulls) &&
            MemoryPlan(context.ram.freeBytes(), context.gpu.freeBytes())
                .grant("tables of an integrator", tableRamBytes(mostEntries, larger),
                       integratorGpuBytes(mostEntries, larger), kPartsForTables, kPartsForTables))
            mayTake = larger;
    if (view.quality.integrator == Integrator::automatic)
        setIntegrator(automaticIntegrator());
}

void Planner::setStep(double stepVoxels) {
    view.quality.stepVoxels = stepVoxels;
    if (layer().mixed())
        layer().levels.mostStride = mostStride(layer().selection, view.quality);
    aim();
    prepareSegments();
}

void Planner::setHullSamples(int samples) {
    if (view.quality.sampling != Sampling::hulls)
        return;
    if (samples == 0)
        view.quality.sampling = Sampling::limited;
    else
        view.quality.hulls.samples = samples;
    setStep(view.quality.stepVoxels);
}

void Planner::setIntegrator(Integrator integrator) {
    if (integrator == layer().optics.integrator)
        return;
    chargeTables(integrator);
    tessera::setIntegrator(layer().optics, integrator);
    revisions.tables = PlanRevisions::next();
    if (!layer().selection.levels.empty())
        prepareSegments();
}

void Planner::prepareSegments() {
    const Strides s = strides();
    const int longest = layer().mixed() ? layer().levels.mostStride
                                        : std::countr_zero(static_cast<unsigned>(s.uniformSegments));
    const int first = layer().mixed() ? 0 : longest;
    preparePreintegration2d(layer().optics, view.quality.stepVoxels * typicalVoxelMm(info()), first,
                            longest - first + 1);
    if (layer().optics.integrator == Integrator::preintegrated2d) // its tables depend on a length
        revisions.tables = PlanRevisions::next();
}

void Planner::setTermination(float transmittance) {
    layer().optics.termination = transmittance;
    revisions.tables = PlanRevisions::next();
}

} // namespace tessera
