// render/backends/gpu/march.cpp: see march.h.
#include "render/backends/gpu/march.h"

#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "render/backends/gpu/bindings.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace tessera {
namespace {

constexpr int kGroup = 8; // local size of the shaders, both axes

struct GpuWork { // layout of the Work buffer in march.comp
    std::uint32_t unfinished, iterations, segments, samples, fetches, blended, waiting;
};
static_assert(sizeof(GpuWork) == kDrawnCounterBytes);

std::string element(const char* array, std::size_t i) {
    return array + ("[" + std::to_string(i) + "]");
}

/// With the features that follow from the optics.
std::uint32_t withOptics(std::uint32_t features, const Optics& optics) {
    features = withLights(features & ~(kIntegratorFeatures | kFeatureSurfaces | kFeatureValues), optics);
    if (features & kFeatureVisibility)
        return withGradientOpacity(features, optics); // light by the midpoint rule, and no isosurfaces
    if (optics.reduction != Reduction::composite)
        return (features | kFeatureValues) &
               ~(kFeatureLabels | kFeatureShading | kFeatureTermination | kGradientFeatures);
    return withGradientOpacity(features | integratorFeatures(optics.integrator) |
                                   (optics.surfaces.empty() ? 0u : std::uint32_t{kFeatureSurfaces}),
                               optics);
}

} // namespace

std::uint32_t withLights(std::uint32_t features, const Optics& optics) {
    features &= ~std::uint32_t{kFeatureLights | kFeatureMaterials | kFeatureVoxelLight | kFeatureEmission};
    if (!(features & kFeatureShading) || !optics.hasLights)
        return features;
    return features | kFeatureLights | (optics.materials.empty() ? 0u : std::uint32_t{kFeatureMaterials}) |
           (optics.lighting.channels == 0 ? 0u : std::uint32_t{kFeatureVoxelLight}) |
           (optics.lighting.emits || optics.lighting.ambientChannels > 1 ? std::uint32_t{kFeatureEmission}
                                                                         : 0u);
}

std::uint32_t withGradientOpacity(std::uint32_t features, const Optics& optics) {
    if (optics.grades())
        return (features & ~kGradientFeatures) | kFeatureGradientOpacity | gradientFeature(optics.gradient);
    if (!(features & kFeatureGradientOpacity))
        return features;
    return features & ~(kFeatureGradientOpacity |
                        (features & (kFeatureShading | kFeatureSurfaces) ? 0u : kGradientFeatures));
}

Composition marchComposition(std::uint32_t features) {
    static const std::vector<StorageBuffer> own = {
        {"COLOUR", "the picture",
         [](const glm::ivec2& image, const glm::ivec3&) { return kRayColourBytes * rayCount(image); }},
        {"NEXT", "the rays' state",
         [](const glm::ivec2& image, const glm::ivec3&) { return kRayNextBytes * rayCount(image); }},
        {"WORK", "the work counters",
         [](const glm::ivec2&, const glm::ivec3&) { return kDrawnCounterBytes; }}};
    return Composition(own, features);
}

void setRayUniforms(const GlProgram& program, const Rays& rays) {
    const RayFrame<float> f = cast<float>(rays.frame);
    program.set("uArraySize", rays.size());
    program.set("uCentre", f.centre);
    program.set("uRight", f.right);
    program.set("uUp", f.up);
    program.set("uToCentre", f.toCentre);
    program.set("uPatientFromVoxel", f.patientFromVoxel);
    program.set("uExtent", f.extent);
    program.set("uImageSize", f.imageSize);
    program.set("uSegmentVoxels", f.segmentVoxels);
    program.set("uPhased", f.phased ? 1 : 0);
    program.set("uPerspective", f.perspective ? 1 : 0);
    program.set("uSlabs", f.slabCount);
    program.set("uFlat", f.flat ? 1 : 0);
    for (std::size_t n = 0; n < static_cast<std::size_t>(f.slabCount); ++n) {
        program.set(element("uSlabNormal", n).c_str(), f.slabs[n].normal);
        program.set(element("uSlabEnds", n).c_str(), glm::vec2(f.slabs[n].low, f.slabs[n].high));
    }
}

March::March(std::uint32_t features, const RayFrame<double>& frame, const VolumeInfo& info,
             const Strides& strides, const Optics& optics, const Occupancy* occupancy, MemoryBudget& gpu)
    : size_(glm::ivec2(frame.imageSize)), features_(withOptics(features, optics)), info_(info), gpu_(gpu),
      occupancy_(occupancy) {
    TESSERA_CHECK((occupancy != nullptr) ==
                  ((features & kFeatureSkipping) != 0 && !(features_ & kFeatureValues)));
    compose();
    if (occupancy)
        skipping_ = GlTexture3d(GL_RG32UI, occupancy->grid(), sizeof(SkippingTexel), GL_NEAREST, gpu,
                                "the map of empty space");
    setFunction(optics);
    restart({frame, strides}, occupancy);
}

void March::compose() {
    const Composition composition = marchComposition(features_);
    program_ = composition.program("march.comp");
    compiled_ = false;
    buffers_.fit(composition, size_, brickGrid(info_.extentVoxels), gpu_);
    if (occupancy_)
        setSkippingUniforms(program_, *occupancy_);
}

void March::setFunction(const Optics& optics) {
    setFeatures(features_, optics);
}

void March::setFeatures(std::uint32_t wanted, const Optics& optics) {
    if (const std::uint32_t features = withOptics(wanted, optics); features != features_) {
        TESSERA_CHECK(((features ^ features_) &
                       (kFeatureSkipping | kFeaturePasses | kFeatureVisibility | kFeatureHits)) == 0);
        features_ = features;
        compose();
    }
    tables_.set(optics, (features_ & kFeaturePreintegrated) != 0, gpu_);
    program_.set("uPreintegrationScale", optics.preintegrationScale);
    program_.set("uSumsStart", static_cast<int>(optics.bins.size()));
    program_.set("uPreintegrationEdge", Preintegration2d::kEdge);
    program_.set("uPreintegrationFirstLayer", optics.seen.firstLayer());
    program_.set("uSurfaces", static_cast<int>(optics.surfaces.size()));
    program_.set("uVolumeShows", optics.volumeShows ? 1 : 0);
    for (std::size_t i = 0; i < optics.surfaces.size(); ++i) {
        program_.set(element("uIsovalues", i).c_str(), optics.surfaces[i].isovalue);
        program_.set(element("uSurfaceColours", i).c_str(), optics.surfaces[i].colour);
        program_.set(element("uSurfaceOpacities", i).c_str(), optics.surfaces[i].opacity);
    }
    program_.set("uTableScale", optics.scale);
    program_.set("uTableOffset", optics.offset);
    program_.set("uTableLast", static_cast<int>(optics.table.size()) - 1);
    program_.set("uVoxelFromPatientTransposed", optics.voxelFromPatientTransposed);
    program_.set("uPhong", optics.phong);
    program_.set("uSpecularPower", optics.specularPower);
    program_.set("uTermination", optics.termination);
    program_.set("uLabelPlain", static_cast<int>(optics.labels.plain));
    program_.set("uLabelTinted", static_cast<int>(optics.labels.tinted));
    program_.set("uLabelSolid", static_cast<int>(optics.labels.solid));
    program_.set("uLabelDense", static_cast<int>(optics.labels.dense));
    program_.set("uLabelColour", static_cast<int>(optics.labels.colour));
    program_.set("uLabelDensity", optics.labels.density);
    program_.set("uLabelSlopes", optics.shading && optics.labels.solid >= 0 ? 6 : 0);
    program_.set("uReduction", static_cast<int>(optics.reduction));
    program_.set("uGradientPoints", optics.gradientOpacity.count);
    for (std::size_t i = 0; i < static_cast<std::size_t>(optics.gradientOpacity.count); ++i)
        program_.set(element("uGradientOpacity", i).c_str(),
                     glm::vec3(optics.gradientOpacity.length[i], optics.gradientOpacity.factor[i],
                               optics.gradientOpacity.slope[i]));
    setLights(optics);
}

void March::setLights(const Optics& optics) {
    if (!(features_ & kFeatureLights))
        return;
    const leaf::LightingNumbers& lighting = optics.lighting;
    program_.set("uLights", lighting.count);
#define SET(type, name, otherwise) program_.set("uLightModel." #name, lighting.model.name);
    LIGHT_MODEL(SET)
#undef SET
    program_.set("uOcclusionChannel", static_cast<int>(lighting.occlusionChannel));
    program_.set("uAmbientChannels", static_cast<int>(lighting.ambientChannels));
    const auto vector = [](const float(&v)[3]) { return glm::vec3(v[0], v[1], v[2]); };
    for (int i = 0; i < lighting.count; ++i) {
        const leaf::LightNumbers& light = lighting.lights[i];
        const auto number = static_cast<std::size_t>(i);
        program_.set(element("uLightSort", number).c_str(), static_cast<int>(light.sort));
        program_.set(element("uLightChannel", number).c_str(), static_cast<int>(light.channel));
        program_.set(element("uLightPlace", number).c_str(), vector(light.place));
        program_.set(element("uLightColour", number).c_str(), vector(light.colour));
        program_.set(element("uLightFading", number).c_str(), vector(light.fading));
    }
    program_.set("uMaterials", static_cast<int>(optics.materials.size()));
    for (std::size_t i = 0; i < optics.materials.size(); ++i) {
        const leaf::MaterialNumbers& m = optics.materials[i];
        program_.set(element("uMaterialPlaces", i).c_str(),
                     glm::vec2(placeOf(optics, m.from), placeOf(optics, m.to)));
        program_.set(element("uMaterialPhong", i).c_str(), glm::vec3(m.ambient, m.diffuse, m.specular));
        program_.set(element("uMaterialPower", i).c_str(), static_cast<int>(m.power));
        program_.set(element("uMaterialEmission", i).c_str(), vector(m.emission));
    }
}

void March::restart(const Rays& rays, const Occupancy* changed) {
    TESSERA_CHECK(rays.places.empty() == !(features_ & kFeaturePlaces));
    TESSERA_CHECK((rays.frame.cuts != nullptr) == ((features_ & kFeatureIntervals) != 0));
    TESSERA_CHECK(rays.frame.slabCount == 0 || (features_ & (kFeatureSlabs | kFeatureVisibility)));
    if (rays.size() != size_) {
        size_ = rays.size();
        buffers_.fit(marchComposition(features_), size_, brickGrid(info_.extentVoxels), gpu_);
    }
    const RayFrame<double>& frame = rays.frame;
    maxCount_ = static_cast<int>(std::ceil(glm::length(frame.extent) / frame.segmentVoxels)) + 2;
    if (changed) {
        TESSERA_CHECK(changed->grid() == skipping_.extent());
        uploadSkipping(skipping_, *changed, changed->changedSince(skippingVersion_));
        skippingVersion_ = changed->version();
    }
    setRayUniforms(program_, rays);
    const Strides& strides = rays.strides;
    program_.set("uStride", strides.uniformSegments);
    program_.set("uStepVoxels", static_cast<float>(strides.segmentVoxels));
    program_.set("uNaive", strides.sampling == Sampling::naive ? 1 : 0);
    buffers_.begin();
    if (features_ & kFeaturePlaces)
        buffers_.put("PLACES", std::as_bytes(rays.places), gpu_);
    tile_ = glm::ivec2(0);
    cuts_.reset();
    round_ = 0;
    if (features_ & kFeatureIntervals) {
        cuts_ = cutRays(frame, rays.places, 0);
        putRound();
    }
}

/// The rays' intervals of the round.
void March::putRound() {
    std::vector<glm::vec2> intervals(rayCount(size_), glm::vec2(0, -1));
    for (std::size_t ray = 0; ray < intervals.size(); ++ray)
        if (round_ < cuts_->count(ray)) {
            const RayInterval& interval = cuts_->at(ray, round_);
            intervals[ray] = {interval.from, interval.to};
        }
    buffers_.put("INTERVALS", std::as_bytes(std::span(intervals)), gpu_);
}

void March::setSurfaceMap(const Occupancy& surfaceOccupancy) {
    TESSERA_CHECK(occupancy_ && surfaceOccupancy.grid() == occupancy_->grid());
    if (surfaceMap_.bytes() == 0)
        surfaceMap_ = GlTexture3d(GL_RG32UI, surfaceOccupancy.grid(), sizeof(SkippingTexel), GL_NEAREST, gpu_,
                                  "the map of isosurfaces");
    uploadSkipping(surfaceMap_, surfaceOccupancy, {0, surfaceOccupancy.grid().z});
}

void March::setBounds(const ValueBounds& bounds) {
    TESSERA_CHECK(features_ & kFeatureValues);
    const auto upload = [&](GlTexture3d& texture, const glm::ivec3& grid, const float* texels) {
        if (texture.extent() != grid)
            texture = GlTexture3d(GL_R32F, grid, sizeof(float), GL_NEAREST, gpu_, "the bounds of values");
        texture.upload(glm::ivec3(0), grid, GL_RED, GL_FLOAT, texels);
    };
    upload(brickBounds_, bounds.bricks(), bounds.brick().data());
    if (!bounds.cell().empty())
        upload(cellBounds_, bounds.cells(), bounds.cell().data());
    boundsOfCells_ = !bounds.cell().empty();
}

std::vector<SurfaceHit> March::hits() const {
    std::vector<SurfaceHit> hits(rayCount(size_));
    buffers_["HITS"].read(0, std::as_writable_bytes(std::span(hits)));
    return hits;
}

std::vector<SeenBrick> March::seen() const {
    std::vector<SeenBrick> seen(cellCount(brickGrid(info_.extentVoxels)));
    buffers_["SEEN"].read(0, std::as_writable_bytes(std::span(seen)));
    return seen;
}

std::vector<std::uint32_t> March::takeWanted() {
    std::vector<std::uint32_t> wanted(cellCount(brickGrid(info_.extentVoxels)));
    GlBuffer& buffer = buffers_["WANTED"];
    buffer.read(0, std::as_writable_bytes(std::span(wanted)));
    buffer.fill(UINT32_MAX);
    return wanted;
}

bool March::runUntil(const FieldSource& source, const Slicing& slicing, Clock::time_point deadline,
                     Work& work) {
    bindField(program_, features_, info_, source);
    if ((features_ & kFeatureSkipping) && (features_ & kFeatureValues)) {
        TESSERA_CHECK(brickBounds_.bytes() > 0);
        brickBounds_.bind(kSkippingUnit);
        (boundsOfCells_ ? cellBounds_ : brickBounds_).bind(kSurfaceMapUnit);
        program_.set("uBrickBounds", static_cast<int>(kSkippingUnit));
        program_.set("uCellBounds", static_cast<int>(kSurfaceMapUnit));
        program_.set("uBoundsOfCells", boundsOfCells_ ? 1 : 0);
        program_.set("uSkippingLast", info_.extentVoxels - 1);
    } else if (features_ & kFeatureSkipping) {
        skipping_.bind(kSkippingUnit);
        (surfaceMap_.bytes() > 0 ? surfaceMap_ : skipping_).bind(kSurfaceMapUnit);
        program_.set("uSurfaceMap", static_cast<int>(kSurfaceMapUnit));
    }
    tables_.bind(program_);
    buffers_.bind();
    GlBuffer& counters = buffers_["WORK"];
    program_.use();

    const auto dispatch = [&](const glm::ivec2& origin, const glm::ivec2& end, int iterations) {
        counters.clear();
        program_.set("uTileOrigin", origin);
        program_.set("uTileEnd", end);
        program_.set("uMaxIterations", iterations);
        const glm::ivec2 groups = (end - origin + (kGroup - 1)) / kGroup;
        const auto start = Clock::now();
        glDispatchCompute(static_cast<GLuint>(groups.x), static_cast<GLuint>(groups.y), 1);
        glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
        glFinish();
        const double ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
        GpuWork counted{};
        counters.read(0, std::as_writable_bytes(std::span(&counted, 1)));
        work += Work{counted.iterations, counted.segments, counted.samples, counted.fetches, counted.blended};
        return std::pair(ms, counted);
    };
    if (!compiled_) // the driver compiles at the first dispatch; that is not ray casting
        dispatch({0, 0}, {1, 1}, 0);
    compiled_ = true;

    if (tile_ == glm::ivec2(0))
        waiting_ = 0;
    bool late = false; // one dispatch at least, or short deadlines would never come to an end
    for (;;) {
        if (tile_.y >= size_.y) {
            tile_ = glm::ivec2(0);
            if (waiting_ > 0 || !cuts_ || round_ + 1 >= cuts_->most)
                return true;
            ++round_;
            putRound();
            buffers_.bind(); // the intervals' is another one
            buffers_["NEXT"].clear();
        }
        // Tiles in rows; the edge is a power of two that keeps whole rays within one dispatch where possible.
        int edge = slicing.fixedTile;
        if (edge == 0) {
            edge = slicing.targetMs < 40 ? 16 : 64; // rays at a tile's edge share less
            while (edge < 4096 &&
                   static_cast<std::size_t>(4 * edge * edge) * static_cast<std::size_t>(maxCount_) <=
                       pace_.iterationsPerDispatch(slicing.targetMs))
                edge *= 2;
            // A row of tiles keeps one height; a tile may only grow where it starts a row.
            if (tile_.x > 0)
                edge = rowEdge_;
            rowEdge_ = edge;
        }
        const glm::ivec2 end = glm::min(tile_ + edge, size_);
        const std::size_t rays =
            static_cast<std::size_t>(end.x - tile_.x) * static_cast<std::size_t>(end.y - tile_.y);
        for (bool unfinished = true; unfinished;) {
            if (late)
                return false;
            int iterations = slicing.fixedIterations;
            if (iterations == 0)
                iterations = static_cast<int>(
                    std::clamp<std::size_t>(pace_.iterationsPerDispatch(slicing.targetMs) / rays, 1,
                                            static_cast<std::size_t>(maxCount_)));
            checkInterrupted();
            const auto [ms, counted] = dispatch(tile_, end, iterations);
            pace_.observe(ms, counted.iterations);
            unfinished = counted.unfinished > 0;
            if (!unfinished)
                waiting_ += counted.waiting;
            ++work.dispatches;
            work.marchMs += ms;
            work.longestDispatchMs = std::max(work.longestDispatchMs, ms);
            late = Clock::now() >= deadline;
            if (slicing.progress) {
                const double before =
                    static_cast<double>(tile_.y) * size_.x + static_cast<double>(tile_.x) * (end.y - tile_.y);
                slicing.progress(
                    (before + static_cast<double>(rays - std::min<std::size_t>(counted.unfinished, rays))) /
                    (static_cast<double>(size_.x) * size_.y));
            }
        }
        tile_.x = end.x;
        if (tile_.x >= size_.x)
            tile_ = {0, end.y};
    }
}

std::size_t March::run(const FieldSource& source, const Slicing& slicing, Work& work) {
    TESSERA_CHECK(runUntil(source, slicing, Clock::time_point::max(), work));
    return waiting_;
}

Image March::image() const {
    Image image(size_);
    buffers_["COLOUR"].read(0, std::as_writable_bytes(std::span(image.pixels)));
    return image;
}

std::vector<SegmentedRay<float>> gpuRays(const RayFrame<double>& frame, MemoryBudget& gpu) {
    return gpuRays(Rays{frame, {}}, gpu);
}

std::vector<SegmentedRay<float>> gpuRays(const Rays& of, MemoryBudget& gpu) {
    constexpr std::size_t kFloats = 12; // per ray, rays.comp
    const glm::ivec2 size = of.size();
    const std::size_t pixels = rayCount(size);
    const bool places = !of.places.empty();
    const Composition composition({{"RAYS", "the rays"}},
                                  (places ? std::uint32_t{kFeaturePlaces} : 0u) |
                                      (of.frame.slabCount > 0 ? std::uint32_t{kFeatureSlabs} : 0u));
    const GlProgram program = composition.program("rays.comp");
    setRayUniforms(program, of);
    GlBuffer buffer(4 * kFloats * pixels, {}, gpu, "the rays");
    buffer.bind(composition.binding("RAYS"));
    GlBuffer through;
    if (places) {
        through = GlBuffer(of.places.size_bytes(), std::as_bytes(of.places), gpu, "the places of the rays");
        through.bind(composition.binding("PLACES"));
    }
    program.use();
    glDispatchCompute(static_cast<GLuint>((size.x + kGroup - 1) / kGroup),
                      static_cast<GLuint>((size.y + kGroup - 1) / kGroup), 1);
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    std::vector<float> raw(kFloats * pixels);
    buffer.read(0, std::as_writable_bytes(std::span(raw)));
    std::vector<SegmentedRay<float>> rays(pixels);
    for (std::size_t i = 0; i < pixels; ++i) {
        const float* r = raw.data() + kFloats * i;
        rays[i].entry = {r[0], r[1], r[2]};
        rays[i].step = {r[3], r[4], r[5]};
        rays[i].direction = {r[6], r[7], r[8]};
        rays[i].segmentMm = r[9];
        rays[i].tail = r[10];
        rays[i].count = std::bit_cast<int>(r[11]);
    }
    return rays;
}

} // namespace tessera
