// render/backends/gpu/march.h: the single-pass ray caster on the GPU: one compute shader over resumable rays,
// cut into tiles and iteration limits so that no dispatch runs long, whatever the scene.
#pragma once

#include "bricking/levels/visibility.h"
#include "core/base/budget.h"
#include "core/base/work.h"
#include "core/image/image.h"
#include "render/backends/gpu/atlas.h"
#include "render/backends/gpu/bindings.h"
#include "render/backends/gpu/composition.h"
#include "render/backends/gpu/features.h"
#include "render/backends/gpu/gl/context.h"
#include "render/backends/gpu/gl/objects.h"
#include "render/backends/gpu/gl/program.h"
#include "render/backends/gpu/marched_volume.h"
#include "render/backends/gpu/skipping_binding.h"
#include "render/contract/optics.h"
#include "render/contract/ray.h"
#include "render/contract/ray_cuts.h"
#include "render/contract/ray_state.h"
#include "render/contract/strides.h"
#include "render/empty_space/occupancy.h"
#include "render/empty_space/value_bounds.h"
#include "render/engine.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <glm/vec2.hpp>
#include <optional>
#include <span>
#include <vector>

namespace tessera {

// The size of the ray caster's next dispatch, learnt from dispatches that ran.

/// Learns the cost of an iteration here and gives the number of them that one dispatch may hold. A dispatch
/// of n rays cannot run more than n times its iteration limit, however dense its tile turns out. Its time is
/// not bounded, because its iterations may cost more than those before.
class DispatchPace {
  public:
    std::size_t iterationsPerDispatch(double targetMs) const {
        return static_cast<std::size_t>(std::clamp(targetMs / msPerIteration_, 16384.0, 4e9));
    }
    void observe(double ms, std::size_t iterations) {
        constexpr std::size_t kTelling = 4096; // below it the cost of the dispatch itself drowns the rest
        if (iterations < kTelling)
            return;
        msPerIteration_ = std::max(ms / static_cast<double>(iterations), msPerIteration_ * 0.7);
    }

  private:
    double msPerIteration_ = 1e-3; // a cautious start: a microsecond
};

/// The ray caster's program, of features that go together (else it throws Error).
/// @param volumes  of kFeatureFused
Composition marchComposition(std::uint32_t features, int volumes = 1);

/// Of all volumes of a march, in order.
using OpticsOfAll = std::span<const Optics* const>;
using SourcesOfAll = std::span<const FieldSource* const>;

class March {
  public:
    using Clock = std::chrono::steady_clock;
    /// Compiles the program and allocates table, distance map and ray state on the GPU budget. Integrator,
    /// isosurfaces and lights are those of optics, whatever features say.
    /// occupancy is needed exactly when features has kFeatureSkipping, but for kFeatureValues, which have
    /// bounds (setBounds()); it and info must outlive this.
    March(std::uint32_t features, const RayFrame<double>& frame, const VolumeInfo& info,
          const Strides& strides, const Optics& optics, const Occupancy* occupancy, MemoryBudget& gpu);
    /// The same through several volumes, with kFeatureFused; the frame is that of their lattice. Lights,
    /// labels, gradient opacity and levels are features where any volume has them.
    /// @param gpu  for the rays
    March(std::uint32_t features, const RayFrame<double>& frame, const Strides& strides,
          const std::vector<VolumeToMarch>& volumes, Fusion rule, MemoryBudget& gpu);

    /// Casts all rays to their end, or (kFeaturePasses) until they wait for absent bricks. Returns how many
    /// wait.
    std::size_t run(const FieldSource& source, const Slicing& slicing, Work& work);
    /// The same as far as it gets: no dispatch but the first begins after the deadline. True when all rays
    /// are at their end or wait; else the next call goes on. The picture does not depend on where it was cut.
    bool runUntil(const FieldSource& source, const Slicing& slicing, Clock::time_point deadline, Work& work);
    bool runUntil(SourcesOfAll sources, const Slicing& slicing, Clock::time_point deadline, Work& work);
    /// Rays that wait for bricks, once runUntil() has said true.
    std::size_t waiting() const { return waiting_; }
    /// The same lights from another camera; restart() must follow.
    void setLights(OpticsOfAll optics);
    /// All rays begin anew, as RayCaster::begin() says. Places are there exactly when the features have
    /// kFeaturePlaces, with which nothing is made: they come by setFeatures(). Slabs with kFeatureSlabs, cuts
    /// exactly with kFeatureIntervals.
    /// @param changed  of every volume, or none: the occupancy that this was made with, where it changed
    /// since,
    ///     else null: then blocks are to be found again (refineSkipping())
    void restart(const Rays& rays, std::span<const Occupancy* const> changed);
    void restart(const Rays& rays, const Occupancy* changed) { restart(rays, std::span(&changed, 1)); }
    /// Another transfer function; restart() must follow. Compiles anew where the integrator is another.
    void setFunction(const Optics& optics) {
        const Optics* const only = &optics;
        setFunction(OpticsOfAll(&only, 1));
    }
    void setFunction(OpticsOfAll optics) { setFeatures(features_, optics); }
    /// The same with other features, which need no other memory but that of places; restart() must follow.
    void setFeatures(std::uint32_t features, OpticsOfAll optics);
    /// kFeatureVisibility: per brick, [z][y][x], its visibility to the rays since they began.
    std::vector<SeenBrick> seen() const;
    /// kFeaturePasses: per brick of a volume the first ray that waits for it, or UINT32_MAX; forgets them.
    std::vector<std::uint32_t> takeWanted(std::size_t volume = 0);
    /// The distance map on the device; with kFeatureSkipping only.
    const GlTexture3d& skippingMap() const { return volumes_.front().skippingMap(); }
    /// With isosurfaces: their own occupancy (Planner::surfaceOccupancy), so that rays solve for them only
    /// near them. Before run(), and again where it changed; without it rays do wherever anything shows.
    void setSurfaceMap(const Occupancy& surfaces) { volumes_.front().setSurfaceMap(surfaces); }
    /// kFeatureValues with kFeatureSkipping: before run(), and again where they changed.
    void setBounds(const ValueBounds& bounds);
    const GlTexture3d& surfaceMap() const { return volumes_.front().surfaceMap(); }
    /// kFeatureHits: of every ray, row by row.
    std::vector<SurfaceHit> hits() const;
    /// The results of the rays; charged by the caller.
    Image image() const;
    const GlProgram& program() const { return program_; }

  private:
    void compose();
    VolumeUniforms uniformsOf(std::size_t volume) const;
    std::size_t firstWanted(std::size_t volume) const;
    glm::ivec3 bricks() const;

    glm::ivec2 size_; // of the array of rays
    std::uint32_t features_;
    Fusion rule_;
    MemoryBudget& gpu_;
    int maxCount_ = 0;        // most iterations any ray can need
    glm::ivec2 tile_{0};      // origin of the tile that is being drawn
    int rowEdge_ = 0;         // edge of the tiles in its row
    std::size_t waiting_ = 0; // rays of the tiles before it
    bool compiled_ = false;   // by the driver
    DispatchPace pace_;
    GlProgram program_;
    std::vector<MarchedVolume> volumes_;
    StorageBuffers buffers_;
    void putRound();
    std::optional<CutRays> cuts_; // kFeatureIntervals
    std::size_t round_ = 0;       // number of the interval at hand
};

/// The features with lights and materials as the optics have them, where the features have shading.
std::uint32_t withLights(std::uint32_t features, const Optics& optics);
/// The features with gradient opacity where the optics have it, and with the gradient that it takes.
std::uint32_t withGradientOpacity(std::uint32_t features, const Optics& optics);
/// Sets the uniforms of common_ray.glsl.
void setRayUniforms(const GlProgram& program, const Rays& rays);
/// The rays that the GPU makes of a frame, or of places, row by row: for runs of the mirror on exactly these.
std::vector<SegmentedRay<float>> gpuRays(const RayFrame<double>& frame, MemoryBudget& gpu);
std::vector<SegmentedRay<float>> gpuRays(const Rays& rays, MemoryBudget& gpu);

} // namespace tessera
