// render/backends/gpu/gpu_caster.cpp: see gpu_caster.h.
#include "render/backends/gpu/gpu_caster.h"

#include "core/base/error.h"
#include "render/backends/gpu/fine_mask.h"
#include "render/contract/kept_value.h"

#include <utility>

namespace tessera {
namespace {

/// That its function, which may change, decides about.
std::uint32_t withFunction(std::uint32_t features, const Optics& optics) {
    return withGradientOpacity(
        withLights((features & ~kIntegratorFeatures) | integratorFeatures(optics.integrator), optics),
        optics);
}

std::uint32_t featuresOf(const FramePlan& scene, const CasterOptions& options) {
    return marchFeatures(scene, options.counting) | (options.hits ? kFeatureHits : 0u) |
           (options.passes ? kFeaturePasses : 0u);
}

} // namespace

GpuCaster::GpuCaster(const FramePlan& scene, GpuEngine& engine, const CasterOptions& options,
                     MemoryBudget& gpu)
    : GpuCaster(scene, engine, featuresOf(scene, options), gpu) {}

GpuCaster::GpuCaster(const FramePlan& scene, GpuEngine& engine, std::uint32_t features, MemoryBudget& gpu)
    : scene_(scene), engine_(engine), gpu_(gpu), features_(withFunction(features, scene.layer().optics)),
      taken_(scene.revisions), fetch_(scene.view.quality.fetch),
      march_(features, scene.view.frame, scene.info(), scene.strides(), scene.layer().optics,
             (features & kFeatureSkipping) && !scene.layer().reduces() ? &scene.layer().occupancy : nullptr,
             gpu) {
    putBounds();
    if ((features & kFeatureSkipping) && scene.layer().mapsSurfaces)
        march_.setSurfaceMap(scene.layer().surfaceOccupancy);
}

void GpuCaster::begin(const Rays& rays) {
    check(rays);
    engine_.settlePlan();
    const PlanRevisions last = std::exchange(taken_, scene_.revisions);
    if (last.function != taken_.function || last.tables != taken_.tables)
        takeFunction();
    const std::uint32_t before = features_;
    if (const Fetch fetch = scene_.view.quality.fetch; fetch != std::exchange(fetch_, fetch))
        features_ = (features_ & ~std::uint32_t{kFeatureHardware}) |
                    (fetch == Fetch::hardware ? std::uint32_t{kFeatureHardware} : 0u);
    features_ = (features_ & ~std::uint32_t{kFeaturePlaces | kFeatureSlabs | kFeatureIntervals}) |
                (rays.frame.cuts ? std::uint32_t{kFeatureIntervals} : 0u) |
                (rays.places.empty() ? 0u : std::uint32_t{kFeaturePlaces}) |
                (rays.frame.slabCount > 0 ? std::uint32_t{kFeatureSlabs} : 0u);
    if (features_ != before)
        march_.setFeatures(features_, scene_.layer().optics);
    putBounds();
    const bool changed = last.emptySpace != taken_.emptySpace && (features_ & kFeatureSkipping) != 0 &&
                         !scene_.layer().reduces();
    march_.setLights(scene_.layer().optics); // the camera may be another
    march_.restart(rays, changed ? &scene_.layer().occupancy : nullptr);
}

/// Those of rays that keep one value, where they are others than on the device.
void GpuCaster::putBounds() {
    const ValueBounds& bounds = scene_.layer().bounds;
    if (!(features_ & kFeatureSkipping) || !scene_.layer().reduces() || boundsVersion_ == bounds.version())
        return;
    march_.setBounds(bounds);
    boundsVersion_ = bounds.version();
}

Image GpuCaster::image() const {
    Image image = march_.image();
    if ((features_ & kFeatureIntervals) && (features_ & kFeatureValues))
        for (glm::vec4& p : image.pixels)
            p = colourOfKept(scene_.layer().optics, KeptValue<float>{p.r, p.g, p.a > 0});
    return image;
}

bool GpuCaster::draw(const Slicing& slicing, Clock::time_point deadline, Work& work) {
    engine_.settleLight(work);
    return march_.runUntil(engine_.field(), slicing, deadline, work);
}

void GpuCaster::takeFunction() {
    features_ = withFunction(features_, scene_.layer().optics);
    march_.setFunction(scene_.layer().optics);
}

void GpuCaster::refine() {
    if (!(features_ & kFeatureSkipping) || (features_ & kFeaturePasses) || scene_.layer().reduces())
        return;
    engine_.settlePlan();
    const Layer& volume = scene_.layer();
    const auto refined = [&](const GlTexture3d& map, const Occupancy& occupancy, const TransferTable& table) {
        if (!refiningPays(occupancy, rayCount(scene_.view.imageSize)) ||
            gpu_.freeBytes() < refiningBytes(table.entries.size()))
            return std::size_t{0};
        return refineSkipping(map, occupancy, table, volume.optics, features_, scene_.info(), engine_.field(),
                              gpu_);
    };
    if (volume.mapsSurfaces)
        refined(march_.surfaceMap(), volume.surfaceOccupancy, volume.surfaceTable);
    refinedCells_ = refined(march_.skippingMap(), volume.occupancy, volume.table);
}

} // namespace tessera
