// render/engine.h: Engine and RayCaster, the interface of the backends that draw. An engine holds the bricks
// of volumes on its device. Its ray caster takes rays through them, as far as a deadline allows, and goes on
// later. The GPU march, the native engine, the mirror (CPU oracle) and the reference are engines. Pictures
// use this interface alone (render/picture/picture.h).
#pragma once

#include "bricking/levels/visibility.h" // SeenBrick
#include "core/base/budget.h"
#include "core/base/error.h"
#include "core/base/work.h"
#include "core/image/image.h"
#include "render/contract/ray.h"
#include "render/contract/ray_state.h"
#include "render/contract/slicing.h"
#include "render/contract/strides.h"
#include "render/light/light_plane.h"
#include "render/light/surface_tracer.h"
#include "render/plan/frame_plan.h"
#include "render/residency/brick_residency.h"
#include "render/residency/pages.h"

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tessera {

/// The rays of a picture: through the middle of every pixel or, where places are given, through those.
struct Rays {
    RayFrame<double> frame; // the picture's, whatever the places, with its slabs and cuts
    Strides strides;
    /// On the picture, in pixels, x right, y down; the middle of the first pixel is (0.5, 0.5). Row by row of
    /// an array whose neighbours are drawn side by side, so they should lie near one another. Of any size,
    /// also beyond the picture's; kept by the caller until the rays are drawn.
    std::span<const glm::vec2> places = {};
    glm::ivec2 arraySize{0}; // of places; columns, rows

    /// Of what is drawn; columns, rows.
    glm::ivec2 size() const { return places.empty() ? glm::ivec2(frame.imageSize) : arraySize; }
};

/// Throws where an engine cannot take such rays.
inline void check(const Rays& rays) {
    TESSERA_CHECK(rays.places.empty() || rays.places.size() == rayCount(rays.arraySize));
    TESSERA_CHECK(!rays.frame.phased || !(rays.frame.cuts || rays.frame.flat));
}

class RayCaster {
  public:
    using Clock = std::chrono::steady_clock;
    virtual ~RayCaster() = default;

    /// All rays begin anew, of a picture or an array of any size, through the plan as it is then: where its
    /// revisions are others, what was made from it is made anew. What rays read must not change until they
    /// are drawn.
    virtual void begin(const Rays& rays) = 0;
    /// Draws as far as it gets: at least a little, and nothing new after the deadline. True when all rays are
    /// at their end or wait for bricks; else the next call goes on. The picture does not depend on where it
    /// was cut.
    virtual bool draw(const Slicing& slicing, Clock::time_point deadline, Work& work) = 0;
    /// Rays that wait, once draw() has said true; 0 where all bricks are there.
    virtual std::size_t waiting() const { return 0; }
    /// Per brick the first ray that waits for it, or UINT32_MAX; forgets them.
    virtual std::vector<std::uint32_t> takeWanted() { return {}; }

    /// Linear, premultiplied, on nothing; of the rays' size(); charged by the caller.
    virtual Image image() const = 0;
    /// CasterOptions::hits: what each ray met first.
    virtual std::vector<SurfaceHit> hits() const { return {}; }
    /// Follows rays among the isosurfaces of the bricks that are drawn, as they are now; null where the
    /// caster has no way of its own to.
    /// @param voxels  of a segment
    virtual std::unique_ptr<SurfaceTracer> surfaceTracer(double voxels) const {
        (void)voxels;
        return nullptr;
    }

    /// Makes distance maps finer where that pays, at once or as rays get there; all bricks must be there, and
    /// stay as they are until the map of empty space is another.
    virtual void refine() {}
    /// Cells that were looked at for that.
    virtual std::size_t refinedCells() const { return 0; }
    /// Bits of features.h that are compiled in; 0 where nothing is.
    virtual std::uint32_t features() const { return 0; }
};

/// Rays that count what they see of bricks, for choosing levels (plan/visibility_rays.h).
class VisibilityCounter {
  public:
    virtual ~VisibilityCounter() = default;
    /// What they read must not change until all is counted.
    virtual void begin() = 0;
    /// As RayCaster::draw().
    virtual bool count(const Slicing& slicing, RayCaster::Clock::time_point deadline) = 0;
    /// Per brick, [z][y][x].
    virtual std::vector<SeenBrick> seen() const = 0;
};

struct CasterOptions {
    bool counting = false; // work counters
    bool hits = false;
    bool passes = false; // some bricks are absent: rays wait for them
};

class Engine {
  public:
    virtual ~Engine() = default;

    struct About {
        std::string device = "CPU";
        std::string version;       // of OpenGL; "" where none is used
        bool choosesSteps = false; // samples have a step, which pixels are tried for
        bool measures = false;     // fast enough for errors to be measured by pixels drawn again
        /// What a scene can need (levels that mix, cuts) is compiled in when a caster is
        /// made, for good.
        bool compiles = false;
        bool filters = false; // Fetch::hardware is another picture than Fetch::exact
    };
    virtual About about() const = 0;
    virtual TextureLimits limits() const { return {}; }

    /// Makes room for bricks of the scenes' volumes, at the levels of their selections; one volume so far
    /// (checked). The plans outlive what is made from this, and stay where they are.
    /// @param pages  of 32^3 samples
    virtual void open(std::span<const FramePlan* const> plans, std::size_t pages) = 0;
    /// Lets go of the volumes and all that was made room for.
    virtual void close() {}
    /// Who is where; null where bricks are read from the cache as they are needed.
    virtual BrickResidency* bricks() { return nullptr; }

    /// Of the volumes that were opened. Several may be there at once, and share the bricks.
    /// @param gpu  what it takes is charged here
    virtual std::unique_ptr<RayCaster> caster(const CasterOptions& options, MemoryBudget& gpu) = 0;
    virtual std::unique_ptr<VisibilityCounter> counter(MemoryBudget& gpu) = 0;
    /// The light of voxels, of what was opened; null where there is none, or all of it is made anew
    /// for every picture.
    virtual LightPlane* light() { return nullptr; }
    /// What the light of voxels came to, for who asks what a picture took; nothing where there is none.
    virtual std::optional<LightReport> lightReport() const { return std::nullopt; }
    /// What went wrong unseen since the last call; empty: nothing.
    virtual std::string fault() { return {}; }
};

} // namespace tessera
