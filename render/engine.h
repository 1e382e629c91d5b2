// render/engine.h: Engine and RayCaster, the interface of ray backends. An engine holds the bricks of volumes
// on its device. Its ray caster casts rays until a deadline, and continues later. Engines are gpu, native,
// mirror (the CPU oracle) and reference. Pictures use only this interface (render/picture/picture.h).
#pragma once

#include "bricking/levels/visibility.h" // SeenBrick
#include "core/base/budget.h"
#include "core/base/error.h"
#include "core/base/work.h"
#include "core/image/image.h"
#include "render/contract/ray.h"
#include "render/contract/ray_state.h"
#include "render/contract/strides.h"
#include "render/light/light_plane.h"
#include "render/light/surface_light.h"
#include "render/parts/part_tree.h" // SegmentRange
#include "render/plan/frame_plan.h"
#include "render/residency/brick_residency.h"
#include "render/residency/pages.h"
#include "render/transport/path_beginning.h"
#include "render/transport/path_scene.h"

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tessera {

/// The rays of a picture: through every pixel centre or, if places are given, through those.
struct Rays {
    RayFrame<double> frame; // that of the picture, with its slabs and cuts
    Strides strides;
    /// Points on the picture, in pixels, x right, y down; the centre of the first pixel is (0.5, 0.5). Row by
    /// row of an array whose neighbours are drawn together, so they should be near one another. The array may
    /// have any size; the caller keeps it until the rays are drawn.
    std::span<const glm::vec2> places = {};
    glm::ivec2 arraySize{0}; // of places or ways; columns, rows
    /// Rays that are no picture's, in place of those through places; in an array of arraySize, likewise. The
    /// frame's cuts do not hold for them.
    std::span<const LightWay> ways = {};
    /// Of samples of pixels, one a place: twice the number in its set, and which of the two sets. None: no
    /// place is one of several.
    std::span<const std::uint32_t> numbers = {};
    /// The segments of every ray of the array that are drawn; none: all. Neither with cuts and ways, nor of
    /// paths. Of engines that say so (EngineTraits::drawsParts); first segments are where strides may start.
    std::span<const SegmentRange> segments = {};
    /// Colours are those of paths of light that begin where a ray sees something; of plans with a transport.
    bool paths = false;
    /// The caster keeps where these paths begin (RayCaster::beginnings()).
    bool beginnings = false;

    /// The place of a ray on the picture, by its number.
    glm::vec2 placeOf(std::size_t number) const {
        const auto width = static_cast<std::size_t>(frame.imageSize.x);
        return places.empty() ? glm::vec2(static_cast<float>(number % width) + 0.5f,
                                          static_cast<float>(number / width) + 0.5f)
                              : places[number];
    }
    std::optional<std::uint32_t> numberOf(std::size_t ray) const {
        return numbers.empty() ? std::nullopt : std::optional(numbers[ray]);
    }
    /// Size of the drawn array; columns, rows.
    glm::ivec2 size() const {
        return places.empty() && ways.empty() ? glm::ivec2(frame.imageSize) : arraySize;
    }
};

/// What paths of light go through in a plan that has a transport.
inline PathScene pathSceneOf(const FramePlan& plan, const Occupancy* occupancy) {
    const Layer& layer = plan.layer();
    PathScene scene =
        pathScene(plan.view.pathLighting, plan.view.camera, plan.info(), layer.optics, layer.extinction,
                  occupancy, plan.view.quality.pixels.seed, layer.function.tissues());
    if (occupancy && layer.mapsSurfaces)
        scene.surfaceOccupancy = &layer.surfaceOccupancy;
    if (scene.transport.response == TransportResponse::contract)
        return scene; // its light is that of the uncut volume
    for (const RaySlab<double>& slab : plan.view.part.slabs)
        scene.slabs.push_back(
            {glm::vec3(slab.normal), static_cast<float>(slab.low), static_cast<float>(slab.high)});
    scene.cuts = plan.view.part.cuts.get();
    return scene;
}

/// Throws if an engine cannot cast such rays.
inline void check(const Rays& rays) {
    TESSERA_CHECK(rays.places.empty() || rays.places.size() == rayCount(rays.arraySize));
    TESSERA_CHECK(rays.ways.empty() || (rays.ways.size() == rayCount(rays.arraySize) && rays.places.empty() &&
                                        !rays.frame.cuts && rays.frame.ends.empty() && !rays.paths));
    TESSERA_CHECK(rays.segments.empty() || (rays.segments.size() == rayCount(rays.size()) &&
                                            !rays.frame.cuts && rays.ways.empty() && !rays.paths));
    TESSERA_CHECK(!rays.frame.phased || !(rays.frame.cuts || rays.frame.flat));
}

class RayCaster {
  public:
    using Clock = std::chrono::steady_clock;
    virtual ~RayCaster() = default;

    /// Begins new rays, of a picture or an array of any size, with the current plan. Data made from the plan
    /// are updated by its revisions. What rays read must not change until they are drawn.
    virtual void begin(const Rays& rays) = 0;
    /// Casts rays, at least a little, and begins nothing after the deadline. True if all rays are finished or
    /// wait for bricks; else the next call continues. The picture does not depend on these interruptions.
    virtual bool draw(const Slicing& slicing, Clock::time_point deadline, Work& work) = 0;
    /// Number of waiting rays, after draw() returned true; 0 if all bricks are resident.
    virtual std::size_t waiting() const { return 0; }
    /// Per brick of a volume the first ray that waits for it, or UINT32_MAX; clears them.
    /// @param volume  0: the plan's first
    virtual std::vector<std::uint32_t> takeWanted(std::size_t volume = 0) {
        (void)volume;
        return {};
    }

    /// Linear, premultiplied, without background; of the rays' size(); charged by the caller.
    virtual Image image() const = 0;
    /// Of sums along rays (ExposedCaster): the window of the last image(). None: rays show no sums.
    virtual std::optional<GreyWindow> window() const { return std::nullopt; }
    /// CasterOptions::hits: the first hit of each ray.
    virtual std::vector<SurfaceHit> hits() const { return {}; }
    /// Of each ray whose first hit is that of a mesh: colour times opacity and material's ambient; such hits
    /// have numbers of surfaces behind the last isosurface's. Empty: there is none.
    virtual std::vector<glm::vec3> meshAmbient() const { return {}; }
    /// Rays::beginnings: of each ray; none: the caster keeps none. Valid until the next begin().
    virtual std::span<const PathBeginning> beginnings() const { return {}; }
    /// A tracer of rays among the isosurfaces of the current bricks; null if the caster has none of its own.
    /// @param voxels  of a segment
    virtual std::unique_ptr<SurfaceTracer> surfaceTracer(double voxels) const {
        (void)voxels;
        return nullptr;
    }

    /// Refines distance maps if that pays, at once or as rays reach cells. All bricks must be resident, and
    /// stay unchanged until the occupancy map changes.
    virtual void refine() {}
    /// Cells examined for that.
    virtual std::size_t refinedCells() const { return 0; }
    /// Bits of features.h that are compiled in; 0 without shaders.
    virtual std::uint32_t features() const { return 0; }
};

/// Rays that count the visibility of bricks, for choosing levels (plan/visibility_rays.h).
class VisibilityCounter {
  public:
    virtual ~VisibilityCounter() = default;
    /// What rays read must not change until all is counted.
    virtual void begin() = 0;
    /// As RayCaster::draw().
    virtual bool count(const Slicing& slicing, RayCaster::Clock::time_point deadline) = 0;
    /// Per brick, [z][y][x].
    virtual std::vector<SeenBrick> seen() const = 0;
};

struct CasterOptions {
    bool counting = false; // work counters
    bool hits = false;
    bool passes = false; // bricks may be absent: rays wait for them
};

class Engine {
  public:
    virtual ~Engine() = default;

    struct About {
        std::string device = "CPU";
        std::string version;       // of OpenGL; "" if it is not used
        bool choosesSteps = false; // it has a step, which a step search chooses
        bool measures = false;     // fast enough to measure errors by drawing pixels again
        bool followsPaths = false; // Rays::paths, of plans without a transport too (Planner::boundLight())
        /// Needs of a scene (mixed levels, cuts) are compiled in when a caster is made, and cannot change.
        bool compiles = false;
        bool filters = false; // Fetch::hardware gives another picture than Fetch::exact
    };
    virtual About about() const = 0;
    virtual TextureLimits limits() const { return {}; }

    /// Allocates memory for bricks of the plan's first volume, at the levels of its selection. Its further
    /// volumes are opened by further(). The plan outlives all objects made from this, and does not move.
    /// @param pages  of 32^3 samples
    virtual void open(const FramePlan& plan, std::size_t pages) = 0;
    /// Releases the volumes and their memory.
    virtual void close() {}
    /// The residency of bricks; null if bricks are read from the cache on demand.
    virtual BrickResidency* bricks() { return nullptr; }
    /// The engine of a further volume of the opened plan, in that volume's share of the memory; to be opened
    /// for its plan before rays begin. Null where bricks are read on demand.
    virtual Engine* further(std::size_t number) {
        (void)number;
        return nullptr;
    }

    /// Makes a caster for the opened volumes. Several may exist at once, and share the bricks.
    /// @param gpu  budget for its memory
    virtual std::unique_ptr<RayCaster> caster(const CasterOptions& options, MemoryBudget& gpu) = 0;
    virtual std::unique_ptr<VisibilityCounter> counter(MemoryBudget& gpu) = 0;
    /// The light per voxel of the opened volumes; null if there is none, or if it is computed for every
    /// picture.
    virtual LightPlane* light() { return nullptr; }
    /// Statistics of the light per voxel, for reports; nullopt if there is none.
    virtual std::optional<LightReport> lightReport() const { return std::nullopt; }
    /// An error that threw nothing, since the last call; empty: none.
    virtual std::string fault() { return {}; }
};

} // namespace tessera
