// tests/bench/path_baselines.h: what others do where the product follows paths, as small as possible, on the
// product's own bricks, numbers and scatterings: only the ways between places differ.
//
// - One majorant: delta tracking (Woodcock et al. 1965) with the greatest extinction of the volume, of every
//   way, shadows and the eye's own among them.
// - Marching: steps of a fixed length from a random shift on, until their sum of extinctions passes a drawn
//   depth; one scattering. SampleDistanceRM() and FreePathRM() of Exposure Render (Kroes et al. 2012,
//   Source/Core/Cuda) and of AGAVE (renderlib, pathTraceVolume.frag). The step biases it.
#pragma once

#include "core/image/image.h"
#include "render/backends/native/native_engine.h"
#include "render/backends/native/native_field.h"
#include "render/plan/planner.h"
#include "tests/bench/bench_tools.h"

namespace tessera::bench {

enum class Tracking { oneMajorant, marching };

/// Process CPU seconds, of all threads.
double cpuSeconds();

/// A scene with a transport, ready to be drawn.
class PathBaseline {
  public:
    PathBaseline(const Scene& scene, const StoreReader& store, Budgets& budgets, int threads);
    /// @param samples  of a pixel, each at a place drawn in it
    /// @param stepVoxels  of marching
    Image draw(Tracking tracking, int samples, std::uint32_t seed, double stepVoxels, PathWork& work) const;

    /// Per mm, at the middles of a grid's voxels over the whole volume; x fastest.
    std::vector<float> extinctions(const glm::ivec3& grid) const;

  private:
    NativeField field() const;
    glm::ivec2 size_;
    int threads_;
    Work loaded_;
    NativeEngine engine_;
    Planner plan_;
};

} // namespace tessera::bench
