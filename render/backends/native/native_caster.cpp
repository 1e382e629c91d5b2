// render/backends/native/native_caster.cpp: see native_caster.h.
#include "render/backends/native/native_caster.h"

#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/threads.h"
#include "render/backends/mirror/mirror.h"
#include "render/backends/native/native_paths.h"
#include "render/backends/native/native_scene.h"
#include "render/backends/native/native_tracer.h"
#include "render/backends/native/native_volumes.h"
#include "render/plan/fusion.h"

#include <algorithm>
#include <mutex>
#include <utility>

namespace tessera {
namespace {

constexpr int kTileEdge = 32;       // rays of the array; a packet's edges divide it
constexpr std::int32_t kEnded = -1; // of a ray, in place of its next segment

SegmentedRay<float> rayOf(const native::PacketJob& job, int lane) {
    SegmentedRay<float> ray;
    ray.entry = {job.entry[0][lane], job.entry[1][lane], job.entry[2][lane]};
    ray.step = {job.step[0][lane], job.step[1][lane], job.step[2][lane]};
    ray.direction = {job.direction[0][lane], job.direction[1][lane], job.direction[2][lane]};
    ray.segmentMm = job.segmentMm[lane];
    ray.tail = job.tail[lane];
    ray.count = job.count[lane];
    return ray;
}

SurfaceHit hitOf(const native::PacketHits& hits, int lane) {
    const auto three = [lane](const float(&v)[3][native::kMostLanes]) {
        return glm::vec3(v[0][lane], v[1][lane], v[2][lane]);
    };
    return {three(hits.position), hits.weight[lane], three(hits.normal), hits.surface[lane]};
}

} // namespace

/// The counts of a thread; added up tile by tile.
struct NativeCaster::Counts {
    Work work;
    Lanes lanes;
    std::size_t waiting = 0;
};

NativeCaster::NativeCaster(const FramePlan& scene, NativeEngine& engine, const CasterOptions& options,
                           MemoryBudget& gpu, const native::PacketTarget* target)
    : scene_(scene), engine_(engine), gpu_(gpu), options_(options),
      target_(target ? *target : native::packetTarget()), mapTaken_(scene.revisions.emptySpace) {
    for (std::size_t n = 0; n < volumes(); ++n)
        wanted_.emplace_back(
            options.passes ? cellCount(brickGrid(planOfVolume(scene_, n).info().extentVoxels)) : 0);
}

const Occupancy* NativeCaster::occupancy(std::size_t number) const {
    const Occupancy& occupancy = planOfVolume(scene_, number).layer().occupancy;
    return scene_.view.quality.skipping && occupancy.exists() ? &occupancy : nullptr;
}

bool NativeCaster::mapsSurfaces() const {
    return occupancy() && scene_.layer().mapsSurfaces;
}

void NativeCaster::begin(const Rays& rays) {
    check(rays);
    rays_ = rays;
    frame_ = cast<float>(rays.frame);
    size_ = rays.size();
    tiles_ = (size_ + (kTileEdge - 1)) / kTileEdge;
    packetFrame_ = packetFrameOf(frame_);
    const std::uint64_t map = scene_.revisions.emptySpace;
    if (std::exchange(mapTaken_, map) != map) { // the blocks are of another map
        blocks_.reset();
        surfaceBlocks_.reset();
    }
    raysCharge_ = {};
    raysCharge_ = gpu_.charge((kRayColourBytes + kRayNextBytes + (options_.hits ? sizeof(SurfaceHit) : 0)) *
                                  rayCount(size_),
                              "the rays");
    colour_.assign(rayCount(size_), glm::vec4(0));
    next_.assign(rayCount(size_), 0);
    for (std::size_t slot = 0; slot < rays.segments.size(); ++slot)
        next_[slot] =
            rays.segments[slot].first < rays.segments[slot].end ? rays.segments[slot].first : kEnded;
    packet_.assign(static_cast<std::size_t>(tiles_.x) * static_cast<std::size_t>(tiles_.y), 0);
    if (options_.hits)
        hits_.assign(rayCount(size_), SurfaceHit());
    beginnings_.assign(rays.beginnings ? rayCount(size_) : 0, PathBeginning());
    lanes_ = {0, 0, target_.lanes()};
    waiting_ = 0;
    cuts_.reset();
    cutsCharge_ = {};
    if (rays.frame.cuts) {
        cuts_ = cutRays(rays.frame, rays.places, engine_.threads());
        cutsCharge_ = gpu_.charge(cuts_->bytes(), "the intervals of rays");
    }
    round_ = 0;
}

/// Rays that have another interval, and behind which something is seen, go on.
void NativeCaster::startRound() {
    const Optics& optics = scene_.layer().optics;
    for (std::size_t slot = 0; slot < next_.size(); ++slot) {
        const bool ends =
            cuts_->count(slot) <= round_ || (!scene_.layer().reduces() && isOpaque(optics, colour_[slot]));
        next_[slot] = ends ? kEnded : 0;
    }
    std::fill(packet_.begin(), packet_.end(), std::uint16_t{0});
}

/// Rays that keep one value have no colour until all their intervals are drawn.
void NativeCaster::colourKeptValues() {
    for (glm::vec4& colour : colour_)
        colour = colourOfKept(scene_.layer().optics, KeptValue<float>{colour.r, colour.g, colour.a > 0});
}

native::PacketScene NativeCaster::packetSceneOfVolume(std::size_t number) const {
    NativeEngine& engine = engineOfVolume(engine_, number);
    return packetSceneOf({planOfVolume(scene_, number), engine.settled(), engine.lightChannels(),
                          engine.labelChannels(), rays_.strides, frame_.flat, cuts_.has_value(),
                          occupancy(number), number == 0 ? blocks_.get() : nullptr,
                          number == 0 ? surfaceBlocks_.get() : nullptr});
}

void NativeCaster::followPaths(const Slicing& slicing, Work& work) {
    constexpr std::size_t kStrip = 512; // rays of a task: paths that go side by side
    MirrorInput input;
    input.optics = &scene_.layer().optics;
    input.occupancy = occupancy();
    input.strides = rays_.strides;
    input.cuts = cuts_ ? &*cuts_ : nullptr;
    input.segmentVoxels = rays_.frame.segmentVoxels;
    const PathScene scene = pathSceneOf(scene_, input.occupancy);
    native::PacketScene packets =
        packetSceneOf({scene_, engine_.settled(), engine_.lightChannels(), engine_.labelChannels(),
                       rays_.strides, false, false, input.occupancy, nullptr, nullptr});
    const auto rays = frameRays(frame_, rays_.places, rays_.arraySize.x);
    const Layer& volume = scene_.layer();
    std::mutex mutex;
    parallelFor(
        (colour_.size() + kStrip - 1) / kStrip, engine_.threads(),
        [&](std::size_t strip) {
            checkInterrupted();
            NativeField field(engine_.plane(), volume.mixed() ? &volume.levels : nullptr,
                              volume.selection.finest(), volume.optics.gradient);
            field.setLabels(engine_.labelChannels(), volume.optics.labels);
            NativePaths paths(scene, input, field, packets, target_);
            Work mine;
            std::vector<SegmentedRay<float>> parts;
            for (std::size_t i = strip * kStrip; i < std::min(colour_.size(), (strip + 1) * kStrip); ++i)
                if (colour_[i].a > 0)
                    paths.add(partsOf(input, rays(i), i, parts), {rays_.placeOf(i), rays_.numberOf(i)},
                              colour_[i], beginnings_.empty() ? nullptr : &beginnings_[i], mine);
            paths.run(mine);
            const std::lock_guard lock(mutex);
            work += mine;
        },
        slicing.progress);
}

bool NativeCaster::draw(const Slicing& slicing, Clock::time_point deadline, Work& work) {
    while (drawRound(slicing, deadline, work)) {
        if (waiting_ > 0)
            return true;
        if (!cuts_ || round_ + 1 >= cuts_->most) {
            if (cuts_ && scene_.layer().reduces())
                colourKeptValues();
            if (rays_.paths)
                followPaths(slicing, work);
            return true;
        }
        ++round_;
        startRound();
        if (Clock::now() >= deadline)
            return false;
    }
    return false;
}

bool NativeCaster::drawRound(const Slicing& slicing, Clock::time_point deadline, Work& work) {
    const auto start = Clock::now();
    std::vector<native::PacketScene> packets;
    for (std::size_t n = 0; n < volumes(); ++n)
        engineOfVolume(engine_, n).settled();
    engine_.castShadows();
    for (std::size_t n = 0; n < volumes(); ++n) {
        engineOfVolume(engine_, n).settledLight(work);
        packets.push_back(packetSceneOfVolume(n));
    }
    march_ = scene_.fused ? target_.fused : target_.march(packets.front());
    const auto packetsOfTile = static_cast<std::uint16_t>(kTileEdge * kTileEdge / target_.lanes());
    if (std::all_of(packet_.begin(), packet_.end(), [&](std::uint16_t p) { return p == packetsOfTile; })) {
        std::fill(packet_.begin(), packet_.end(), std::uint16_t{0}); // rays that waited go on
        waiting_ = 0;
    }
    std::atomic<bool> late{false};
    std::mutex mutex;
    const auto tile = [&](std::size_t number) {
        if (packet_[number] == packetsOfTile || late.load(std::memory_order_relaxed))
            return;
        NativeVolumes mine(scene_, engine_, rays_.strides, packets, deadline, late);
        Counts counts;
        const glm::ivec2 first =
            kTileEdge * glm::ivec2(static_cast<int>(number) % tiles_.x, static_cast<int>(number) / tiles_.x);
        const int perRow = kTileEdge / target_.columns;
        for (std::uint16_t& p = packet_[number]; p < packetsOfTile;) {
            const glm::ivec2 origin =
                first + glm::ivec2(p % perRow, p / perRow) * glm::ivec2(target_.columns, target_.rows);
            const bool ended =
                glm::any(glm::greaterThanEqual(origin, size_)) || drawPacket(origin, mine, slicing, counts);
            p = static_cast<std::uint16_t>(p + (ended ? 1 : 0));
            if (mine.expired())
                break;
        }
        const std::lock_guard lock(mutex);
        work += counts.work;
        lanes_.turns += counts.lanes.turns;
        lanes_.used += counts.lanes.used;
        waiting_ += counts.waiting;
    };
    parallelFor(packet_.size(), engine_.threads(), tile,
                deadline == Clock::time_point::max() ? slicing.progress : ShareDone{});
    const double ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
    ++work.dispatches;
    work.marchMs += ms;
    work.longestDispatchMs = std::max(work.longestDispatchMs, ms);
    return std::all_of(packet_.begin(), packet_.end(), [&](std::uint16_t p) { return p == packetsOfTile; });
}

glm::vec2 NativeCaster::placeOf(const glm::ivec2& at, std::size_t slot) const {
    return rays_.places.empty() ? glm::vec2(at) + 0.5f : rays_.places[slot];
}

/// Reads all that the next stride of a ray among surfaces needs.
void NativeCaster::nameStride(NativeField& field, const SegmentedRay<float>& ray, int i,
                              const glm::vec4& sum) {
    MirrorInput input;
    input.optics = &scene_.layer().optics;
    input.occupancy = occupancy();
    input.surfaceOccupancy = mapsSurfaces() ? &scene_.layer().surfaceOccupancy : nullptr;
    input.strides = rays_.strides;
    Work unused;
    SurfaceHit nowhere;
    SurfaceRayState<float> state{i, sum};
    surfaceRay(ray, field, input, unused, options_.hits ? &nowhere : nullptr, state);
}

/// True when all rays of it are at their end or wait.
bool NativeCaster::drawPacket(const glm::ivec2& origin, NativeVolumes& volumes, const Slicing& slicing,
                              Counts& counts) {
    native::PacketJob job;
    native::PacketHits hits;
    native::PacketPlaces places{};
    std::size_t slots[native::kMostLanes] = {};
    bool within[native::kMostLanes] = {}, any = false;
    for (int lane = 0; lane < target_.lanes(); ++lane) {
        const glm::ivec2 at = origin + glm::ivec2(lane % target_.columns, lane / target_.columns);
        within[lane] = glm::all(glm::lessThan(at, size_));
        if (!within[lane])
            continue;
        slots[lane] = static_cast<std::size_t>(at.y) * static_cast<std::size_t>(size_.x) +
                      static_cast<std::size_t>(at.x);
        const glm::vec2 place = placeOf(at, slots[lane]);
        places.x[lane] = place.x, places.y[lane] = place.y;
        places.phase[lane] = rays_.frame.phased ? phaseOf<float>(at.x, at.y) : 0;
    }
    target_.rays(packetFrame_, places, job);
    for (int lane = 0; !rays_.ways.empty() && lane < target_.lanes(); ++lane)
        setRay(job, lane,
               within[lane] ? segmentedWay<float>(rays_.ways[slots[lane]], rays_.frame.segmentVoxels)
                            : SegmentedRay<float>());
    for (int lane = 0; !rays_.segments.empty() && lane < target_.lanes(); ++lane)
        if (const std::int32_t end = within[lane] ? rays_.segments[slots[lane]].end : 0;
            end < job.count[lane]) {
            job.count[lane] = end;
            job.tail[lane] = 1;
        }
    for (int lane = 0; cuts_ && lane < target_.lanes(); ++lane) {
        if (!within[lane])
            continue;
        const bool has = round_ < cuts_->count(slots[lane]);
        const SegmentedRay<float> part = has ? partOf(rayOf(job, lane), cuts_->at(slots[lane], round_),
                                                      frame_.segmentVoxels, frame_.hullSamples())
                                             : SegmentedRay<float>();
        for (int axis = 0; axis < 3; ++axis) {
            job.entry[axis][lane] = part.entry[axis];
            job.step[axis][lane] = part.step[axis];
        }
        job.segmentMm[lane] = part.segmentMm;
        job.tail[lane] = part.tail;
        job.count[lane] = part.count;
    }
    for (int lane = 0; lane < target_.lanes(); ++lane) {
        glm::vec4 colour(0);
        job.next[lane] = 0;
        if (!within[lane]) {
            job.count[lane] = 0;
        } else {
            if (next_[slots[lane]] == kEnded)
                job.count[lane] = 0;
            job.next[lane] = next_[slots[lane]];
            colour = colour_[slots[lane]];
            any = any || job.count[lane] > 0;
            if (options_.hits)
                hits.surface[lane] = hits_[slots[lane]].surface;
        }
        for (int c = 0; c < 4; ++c)
            job.colour[c][lane] = colour[c];
    }
    if (!any)
        return true;
    job.hits = options_.hits ? &hits : nullptr;
    job.turns = slicing.fixedIterations;
    march_(volumes.scene(), job);
    bool ended = true;
    const bool surfaces = !scene_.layer().optics.surfaces.empty();
    for (int lane = 0; lane < target_.lanes(); ++lane) {
        if (job.count[lane] == 0)
            continue;
        const std::size_t slot = slots[lane];
        colour_[slot] = {job.colour[0][lane], job.colour[1][lane], job.colour[2][lane], job.colour[3][lane]};
        next_[slot] = job.next[lane] < job.count[lane] ? job.next[lane] : kEnded;
        if (options_.hits && hits_[slot].surface == 0 && hits.surface[lane] != 0)
            hits_[slot] = hitOf(hits, lane);
        if (job.waiting >> lane & 1u) {
            ++counts.waiting;
            volumes.name(&wanted_, static_cast<std::uint32_t>(slot));
            if (surfaces)
                nameStride(volumes.field(), rayOf(job, lane), job.next[lane], colour_[slot]);
            else
                volumes.readSample(rayOf(job, lane), job.next[lane]);
            volumes.name(nullptr, 0);
        } else {
            ended = ended && next_[slot] == kEnded;
        }
    }
    counts.work.iterations += job.iterations;
    counts.work.segments += job.segments;
    counts.work.samples += job.values + job.gradients * static_cast<std::uint64_t>(
                                                            gradientValues(scene_.layer().optics.gradient));
    counts.lanes.turns += job.turnsTaken;
    counts.lanes.used += job.values;
    return ended;
}

std::unique_ptr<SurfaceTracer> NativeCaster::surfaceTracer(double voxels) const {
    if (options_.passes) // bricks may be absent
        return nullptr;
    const Optics& optics = scene_.layer().optics;
    if (optics.volumeShows && optics.grades() &&
        (optics.gradient == Gradient::analytic || optics.gradient == Gradient::cubic))
        return nullptr; // gradients one by one, with what a thread keeps
    return std::make_unique<NativeTracer>(packetScene(), target_, voxels);
}

Image NativeCaster::image() const {
    Image image(size_);
    image.pixels = colour_;
    return image;
}

void NativeCaster::refine() {
    // Pixels that decide how many rays they take have about two in the mean, and more for an error's sake.
    constexpr int kDecided = 2, kForAnError = 16;
    const Quality& quality = scene_.view.quality;
    const int ofPixel = quality.pixels.samples != PixelSampling::kAutomatic ? quality.pixels.samples
                        : quality.maxError.value_or(0) > 0                  ? kForAnError
                                                                            : kDecided;
    if (FineBlocks::pay(scene_.layer().mixed(), ofPixel * raysPerCell(scene_.view.frame)))
        findBlocks();
}

void NativeCaster::findBlocks() {
    const Occupancy* const all = occupancy();
    const Layer& volume = scene_.layer();
    if (!all || all->scale() != MapScale::cells || options_.passes || volume.showsMedium() || scene_.fused)
        return;
    const auto finer = [&](const Occupancy& cells, const TransferTable& table) {
        const FineBlocksInput input{
            engine_.settled(),         cells, volume.statistics, volume.mixed() ? &volume.levels : nullptr,
            volume.selection.finest(), table, volume.optics,     target_};
        return gpu_.freeBytes() < FineBlocks::bytes(cells) ? nullptr
                                                           : std::make_unique<FineBlocks>(input, gpu_);
    };
    blocks_ = finer(*all, volume.table);
    if (mapsSurfaces())
        surfaceBlocks_ = finer(volume.surfaceOccupancy, volume.surfaceTable);
}

std::size_t NativeCaster::refinedCells() const {
    return (blocks_ ? blocks_->looked() : 0) + (surfaceBlocks_ ? surfaceBlocks_->looked() : 0);
}

} // namespace tessera
