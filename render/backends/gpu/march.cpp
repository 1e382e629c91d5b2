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

/// With the features that follow from the optics of a volume.
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

std::uint32_t withOptics(std::uint32_t features, OpticsOfAll all) {
    std::uint32_t needed = 0;
    for (const Optics* optics : all)
        needed |= withOptics(features, *optics);
    return needed;
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

Composition marchComposition(std::uint32_t features, int volumes) {
    static const std::vector<StorageBuffer> own = {
        {"COLOUR", "the picture",
         [](const glm::ivec2& image, const glm::ivec3&) { return kRayColourBytes * rayCount(image); }},
        {"NEXT", "the rays' state",
         [](const glm::ivec2& image, const glm::ivec3&) { return kRayNextBytes * rayCount(image); }},
        {"WORK", "the work counters",
         [](const glm::ivec2&, const glm::ivec3&) { return kDrawnCounterBytes; }}};
    return Composition(own, features, featureModules(), volumes);
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
    program.set("uHullSamples", f.hullSamples());
    for (std::size_t n = 0; n < static_cast<std::size_t>(f.slabCount); ++n) {
        program.set(element("uSlabNormal", n).c_str(), f.slabs[n].normal);
        program.set(element("uSlabEnds", n).c_str(), glm::vec2(f.slabs[n].low, f.slabs[n].high));
    }
}

namespace {

void setCut(const GlProgram& program, std::size_t number, const leaf::CutSlab& slab) {
    const auto set = [&](const char* uniform, const auto& value) {
        program.set((uniform + ("[" + std::to_string(number) + "]")).c_str(), value);
    };
    set("uCutNormals", glm::vec3(slab.normal[0], slab.normal[1], slab.normal[2]));
    set("uCutEnds", glm::vec2(slab.low, slab.high));
    set("uCutBodies", (slab.endsBody ? 1 : 0) + (slab.keepsOutside ? 2 : 0));
}

} // namespace

March::March(std::uint32_t features, const RayFrame<double>& frame, const VolumeInfo& info,
             const Strides& strides, const Optics& optics, const Occupancy* occupancy, MemoryBudget& gpu)
    : March(features, frame, strides, {VolumeToMarch{&info, &optics, occupancy, &gpu}}, Fusion::mix, gpu) {}

March::March(std::uint32_t features, const RayFrame<double>& frame, const Strides& strides,
             const std::vector<VolumeToMarch>& volumes, Fusion rule, MemoryBudget& gpu)
    : size_(glm::ivec2(frame.imageSize)), rule_(rule), gpu_(gpu) {
    TESSERA_CHECK(volumes.size() == 1 || (features & kFeatureFused));
    std::vector<const Optics*> optics;
    std::vector<const Occupancy*> occupancies;
    for (const VolumeToMarch& volume : volumes) {
        optics.push_back(volume.optics);
        occupancies.push_back(volume.occupancy);
    }
    features_ = withOptics(features, optics);
    for (const VolumeToMarch& volume : volumes) {
        TESSERA_CHECK((volume.occupancy != nullptr) ==
                      ((features & kFeatureSkipping) != 0 && !(features_ & kFeatureValues)));
        volumes_.emplace_back(volume);
    }
    compose();
    setFunction(optics);
    restart({frame, strides}, occupancies);
}

VolumeUniforms March::uniformsOf(std::size_t volume) const {
    return VolumeUniforms(program_, features_ & kFeatureFused ? static_cast<int>(volume) : -1);
}

std::size_t March::firstWanted(std::size_t volume) const {
    std::size_t first = 0;
    for (std::size_t n = 0; n < volume; ++n)
        first += volumes_[n].bricks();
    return first;
}

/// Of all volumes, as a grid of as many.
glm::ivec3 March::bricks() const {
    return {static_cast<int>(firstWanted(volumes_.size())), 1, 1};
}

void March::compose() {
    const Composition composition = marchComposition(features_, static_cast<int>(volumes_.size()));
    program_ = composition.program("march.comp");
    compiled_ = false;
    buffers_.fit(composition, size_, bricks(), gpu_);
    std::size_t cut = 0;
    for (std::size_t n = 0; n < volumes_.size(); ++n) {
        volumes_[n].introduce(uniformsOf(n), firstWanted(n), cut);
        for (const leaf::CutSlab& slab : volumes_[n].of().cuts)
            setCut(program_, cut++, slab);
    }
    program_.set("uCellCorners", 8);
    program_.set("uAxes", 3);
    program_.set("uVolumes", static_cast<int>(volumes_.size()));
    program_.set("uFusion", static_cast<int>(rule_));
}

void March::setFeatures(std::uint32_t wanted, OpticsOfAll all) {
    TESSERA_CHECK(all.size() == volumes_.size());
    if (const std::uint32_t features = withOptics(wanted, all); features != features_) {
        TESSERA_CHECK(((features ^ features_) & (kFeatureSkipping | kFeaturePasses | kFeatureVisibility |
                                                 kFeatureHits | kFeatureFused)) == 0);
        features_ = features;
        compose();
    }
    for (std::size_t n = 0; n < volumes_.size(); ++n)
        volumes_[n].setFunction(uniformsOf(n), features_, *all[n]);
    const Optics& optics = *all.front();
    program_.set("uPreintegrationEdge", Preintegration2d::kEdge);
    program_.set("uSurfaces", static_cast<int>(optics.surfaces.size()));
    program_.set("uVolumeShows", optics.volumeShows ? 1 : 0);
    for (std::size_t i = 0; i < optics.surfaces.size(); ++i) {
        program_.set(element("uIsovalues", i).c_str(), optics.surfaces[i].isovalue);
        program_.set(element("uSurfaceColours", i).c_str(), optics.surfaces[i].colour);
        program_.set(element("uSurfaceOpacities", i).c_str(), optics.surfaces[i].opacity);
    }
    program_.set("uPhong", optics.phong);
    program_.set("uSpecularPower", optics.specularPower);
    program_.set("uTermination", optics.termination);
    program_.set("uReduction", static_cast<int>(optics.reduction));
    program_.set("uNormalReach", static_cast<float>(reachOf(optics.normals)));
}

void March::setLights(OpticsOfAll optics) {
    if (!(features_ & kFeatureLights))
        return;
    for (std::size_t n = 0; n < volumes_.size(); ++n)
        MarchedVolume::setLights(uniformsOf(n), *optics[n]);
}

void March::restart(const Rays& rays, std::span<const Occupancy* const> changed) {
    TESSERA_CHECK(rays.places.empty() == !(features_ & kFeaturePlaces));
    TESSERA_CHECK((rays.frame.cuts != nullptr) == ((features_ & kFeatureIntervals) != 0));
    TESSERA_CHECK(rays.frame.slabCount == 0 || (features_ & (kFeatureSlabs | kFeatureVisibility)));
    if (rays.size() != size_) {
        size_ = rays.size();
        buffers_.fit(marchComposition(features_, static_cast<int>(volumes_.size())), size_, bricks(), gpu_);
    }
    const RayFrame<double>& frame = rays.frame;
    maxCount_ = std::max(static_cast<int>(std::ceil(glm::length(frame.extent) / frame.segmentVoxels)) + 2,
                         frame.hullSamples());
    for (std::size_t n = 0; n < changed.size(); ++n)
        if (changed[n])
            volumes_[n].takeOccupancy(*changed[n]);
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

void March::setBounds(const ValueBounds& bounds) {
    TESSERA_CHECK(features_ & kFeatureValues);
    volumes_.front().setBounds(bounds);
}

std::vector<SurfaceHit> March::hits() const {
    std::vector<SurfaceHit> hits(rayCount(size_));
    buffers_["HITS"].read(0, std::as_writable_bytes(std::span(hits)));
    return hits;
}

std::vector<SeenBrick> March::seen() const {
    std::vector<SeenBrick> seen(volumes_.front().bricks());
    buffers_["SEEN"].read(0, std::as_writable_bytes(std::span(seen)));
    return seen;
}

std::vector<std::uint32_t> March::takeWanted(std::size_t volume) {
    std::vector<std::uint32_t> wanted(volumes_[volume].bricks());
    const std::size_t first = firstWanted(volume) * sizeof(std::uint32_t);
    GlBuffer& buffer = buffers_["WANTED"];
    buffer.read(first, std::as_writable_bytes(std::span(wanted)));
    buffer.fill(UINT32_MAX, first, wanted.size() * sizeof(std::uint32_t));
    return wanted;
}

bool March::runUntil(const FieldSource& source, const Slicing& slicing, Clock::time_point deadline,
                     Work& work) {
    const FieldSource* const only = &source;
    return runUntil(std::span(&only, 1), slicing, deadline, work);
}

bool March::runUntil(SourcesOfAll sources, const Slicing& slicing, Clock::time_point deadline, Work& work) {
    TESSERA_CHECK(sources.size() == volumes_.size());
    for (std::size_t n = 0; n < volumes_.size(); ++n)
        volumes_[n].bind(uniformsOf(n), features_, *sources[n]);
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
        Work done;
        done.iterations = counted.iterations, done.segments = counted.segments,
        done.samples = counted.samples;
        done.fetches = counted.fetches, done.blended = counted.blended;
        work += done;
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
