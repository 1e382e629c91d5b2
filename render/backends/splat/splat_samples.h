// render/backends/splat/splat_samples.h: the samples of a brick that show something, by slice: read,
// classified and lit, each once (docs/sampling.md, "Splats").
#pragma once

#include "core/base/brick.h"
#include "render/backends/splat/splat_projection.h"
#include "render/plan/frame_plan.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <utility>
#include <vector>

namespace tessera {

/// The order of slices: along which axis of the lattice, and whether from its end on.
struct SliceOrder {
    int axis = 2;
    bool fromEnd = false;

    /// The one whose slices face the camera most; and others that face it nearly as much, with shares of the
    /// picture, so that it changes from one to another without a jump.
    /// @param fade  degrees by which an order may be worse until it has no share; 0: there is one
    static std::vector<std::pair<SliceOrder, double>> of(const SplatView& view, const VolumeInfo& info,
                                                         double fade);
    /// The axes within a slice, ascending.
    std::pair<int, int> others() const { return {axis == 0 ? 1 : 0, axis == 2 ? 1 : 2}; }
    /// Of a sample in its brick: slice, and the place in it.
    glm::ivec3 sample(int slice, int place) const {
        glm::ivec3 at;
        at[axis] = slice;
        at[others().first] = place & 31;
        at[others().second] = place >> 5;
        return at;
    }
};

struct ShownSample {
    /// In its slice: samples along the first other axis, 32 times the second.
    std::uint16_t place : 10 = 0;
    std::uint16_t halvings : 6 = 0; // of the unit of its colour, from SampleLister::brightest() on
    std::uint16_t red = 0, green = 0, blue = 0; // lit, in 1/65535 of the unit
    float mass = 0;                             // extinction times its volume, mm^2
};

/// The shown samples of some slices of a brick.
struct BrickList {
    glm::ivec3 brick{0};
    int level = 0;
    int firstSlice = 0;                             // of its level's, in the brick
    std::vector<ShownSample> samples;               // by slice, then by place
    std::array<std::uint16_t, kBrickExtent> ends{}; // of the slices from firstSlice on, in samples

    std::span<const ShownSample> of(int slice) const {
        const auto n = static_cast<std::size_t>(slice - firstSlice);
        const std::size_t from = n == 0 ? 0 : ends[n - 1];
        return std::span(samples).subspan(from, ends[n] - from);
    }
};

class SampleLister {
  public:
    /// All of it outlives this.
    SampleLister(const FramePlan& plan, const SplatView& view, const SliceOrder& order);

    /// Thread-safe. At most as many samples as the slices have.
    /// @param brick  a brick that shows something
    /// @param firstSlice, slices  of its level's, in the brick
    BrickList list(const glm::ivec3& brick, int firstSlice, int slices) const;
    /// The brightest component of a colour.
    float brightest() const { return brightest_; }

  private:
    struct Values;
    Values read(const glm::ivec3& brick, int level) const;
    void readFaces(const glm::ivec3& brick, Values& values) const;
    bool classify(const Values& values, const glm::ivec3& at, ShownSample& sample) const;

    const FramePlan& plan_;
    const SplatView& view_;
    SliceOrder order_;
    double voxelMm3_;
    glm::vec3 parallel_; // direction of a parallel camera's rays, unit, voxels
    float brightest_;
    bool gradients_;
};

} // namespace tessera
