// tests/bench/accuracy/device_scene.h: a scene's bricks on a device at one level of detail, and GPU ray
// casters over them. These are made once and draw many times, so that frames of a viewer are timed without
// compiling and loading.
#pragma once

#include "core/image/image.h"
#include "render/backends/engine_maker.h"
#include "render/picture/render_scene.h"
#include "render/plan/planner.h"
#include "tests/bench/accuracy/setting.h"

#include <memory>
#include <optional>
#include <string>

namespace tessera::accuracy {

/// Whole in device memory after it is made: no passes. What makes its engine must outlive it.
class DeviceScene {
  public:
    /// @param gpuBytes  budget of bricks, tables and one picture
    /// Throws InputError for budgets below the floor, and where the levels that detail asks for do not fit at
    /// once.
    DeviceScene(const Scene& scene, const Detail& detail, const StoreReader& store,
                const EngineMaker& engines, MemoryBudget& ram, std::size_t gpuBytes);
    DeviceScene(const DeviceScene&) = delete; // the field points into it
    DeviceScene& operator=(const DeviceScene&) = delete;

    const FramePlan& prepared() const { return prepared_; }
    /// Budget under which its bricks would have so many times less room.
    std::size_t gpuBytesForShare(int share) const;
    std::size_t gpuFreeBytes() const { return gpu_.freeBytes(); }
    const Work& uploads() const { return uploads_; }
    std::uint64_t bytesDecoded() const { return bytesDecoded_; }
    std::size_t peakRamBytes() const { return peakRam_; }

  private:
    friend class DeviceMarch;

    std::size_t fixedBytes_ = 0; // of a picture besides its bricks
    MemoryBudget
        ram_; // what is free of the caller's when this is made; what stays is charged to the caller's
    MemoryBudget gpu_;
    Planner prepared_;
    std::unique_ptr<Engine> engine_; // after the plan, which it draws
    TextureLimits limits_;
    Work uploads_;
    std::uint64_t bytesDecoded_ = 0;
    std::size_t peakRam_ = 0;
    Charge kept_;
};

struct Frame {
    double wallMs = 0; // from the start of all rays to the picture in RAM
    double gpuMs = 0;  // of that, dispatches
    Work work;         // counted only where the ray caster counts
    Image image;
};

/// A GPU ray caster over a device scene; all of a setting but its step is fixed.
class DeviceMarch {
  public:
    /// @param counting  count the work; such frames are not to be timed
    DeviceMarch(DeviceScene& on, const Scene& scene, const Setting& setting, bool counting);
    /// With preintegrated2d, whose tables are for a step, only the setting's own step is allowed (checked).
    Frame draw(double stepVoxels);
    Integrator integrator() const { return integrator_; } // never automatic
    /// Bricks included.
    std::size_t gpuBytes() const { return on_.gpu_.usedBytes() + gpu_.peakBytes(); }
    /// "shading+skipping+...": what is compiled, besides counting; empty where nothing is.
    std::string features() const;

  private:
    DeviceScene& on_;
    Scene scene_;
    Setting setting_;
    MemoryBudget gpu_;
    Integrator integrator_ = Integrator::midpoint;
    std::unique_ptr<RayCaster> caster_;
};

} // namespace tessera::accuracy
