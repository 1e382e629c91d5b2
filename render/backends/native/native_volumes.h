// render/backends/native/native_volumes.h: the volumes of a plan as one thread of the native engine reads
// them: packets' scenes, and the scalar text, to which packets leave rare work.
#pragma once

#include "render/backends/native/native_engine.h"
#include "render/backends/native/native_field.h"
#include "render/backends/native/packet.h"
#include "render/contract/ray.h"
#include "render/contract/strides.h"
#include "render/engine.h"
#include "render/plan/frame_plan.h"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tessera {

/// 0: the plan's first.
const FramePlan& planOfVolume(const FramePlan& plan, std::size_t number);
NativeEngine& engineOfVolume(NativeEngine& engine, std::size_t number);

class NativeVolumes {
  public:
    using Clock = RayCaster::Clock;
    /// All outlive it.
    /// @param engine  opened for the plan, its bricks settled
    /// @param scenes  of all volumes
    /// @param late    set, and read, where the deadline has passed
    NativeVolumes(const FramePlan& plan, NativeEngine& engine, const Strides& strides,
                  std::vector<native::PacketScene> scenes, Clock::time_point deadline,
                  std::atomic<bool>& late);
    NativeVolumes(const NativeVolumes&) = delete;
    NativeVolumes& operator=(const NativeVolumes&) = delete;

    /// Of all: the first's, which leads to the others.
    const native::PacketScene& scene() const { return scenes_.front(); }
    /// Of the first volume.
    NativeField& field() { return fields_.front(); }
    /// True if packets must stop. Throws what Ctrl-C and calls for cancellation throw.
    bool expired() const;
    /// From now on bricks that are read are named for a ray, by volume; null: no longer.
    void name(std::vector<WantedBricks>* wanted, std::uint32_t ray);
    /// Reads all that the sample of a ray at segment i needs, in a volume without surfaces.
    void readSample(const SegmentedRay<float>& ray, int i);

  private:
    struct Context {
        NativeField& field;
        Clock::time_point deadline;
        std::atomic<bool>& late;
    };
    static native::PacketHelp helpOf(const Context& context);

    const FramePlan& plan_;
    const Strides& strides_;
    std::vector<NativeField> fields_;
    std::vector<Context> contexts_;
    std::vector<native::PacketScene> scenes_;
    native::PacketFusion fusion_; // of several
};

} // namespace tessera
