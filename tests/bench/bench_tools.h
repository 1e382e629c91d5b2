// tests/bench/bench_tools.h: tools that the benchmarks share: a scene loaded once and drawn many times on one
// device, and volumes in memory or in a scratch store. Also minima and medians, and options of the form
// --name value.
//
// A frame's time: all dispatches of the GPU ray caster, each waited for, and the copy of the float picture to
// the host. Compilation and uploads happen once a scene in a viewer; they are not part of a frame.
#pragma once

#include "bricking/import/source/slab_source.h"
#include "core/base/budget.h"
#include "core/base/program_folders.h"
#include "core/base/work.h"
#include "core/image/image.h"
#include "core/scene/scene.h"
#include "render/backends/gpu/gl/context.h"
#include "render/backends/gpu/gpu_engine.h"
#include "render/plan/planner.h"

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace tessera::bench {

using Clock = std::chrono::steady_clock;
inline double msSince(Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/// A benchmark's main: 0, 2 for bad use or input, 1 for anything else, with one line that starts with name.
int runMain(const char* name, void (*run)(int, char**), int argc, char** argv);

double minimum(const std::vector<double>& values); // of at least one
double median(std::vector<double> values);         // of at least one; the mean of the middle two

/// Memory budgets wide enough that they affect no benchmark.
struct Budgets {
    explicit Budgets(std::size_t gpuBytes = std::size_t{4} << 30, std::size_t ramBytes = std::size_t{2} << 30)
        : ram("RAM", "--ram", ramBytes), gpu("GPU memory", "--gpu-memory", gpuBytes) {}
    MemoryBudget ram, gpu;
};

/// One frame of a SceneOnDevice.
struct Frame {
    double ms = 0; // dispatches and read-back, see above
    double wallMs =
        0;     // the same by the wall clock, with the driver's compilation and what lies between dispatches
    Work work; // counters only where the features count
};

/// A scene's volume on the GPU, ready to be drawn at any image size. One GL context must be current.
class SceneOnDevice {
  public:
    /// @param scene  its fitted camera is placed for a square image
    SceneOnDevice(const Scene& scene, const StoreReader& store, const GlContext& context, Budgets& budgets);
    /// Features that the scene and the volume's type call for, without kFeatureCounting.
    std::uint32_t features(Fetch fetch) const;
    /// @param stepVoxels  q of docs/sampling.md; picture: where the result goes, or null
    Frame draw(const glm::ivec2& size, double stepVoxels, std::uint32_t features, Image* picture);
    const FramePlan& prepared() const { return prepared_; }
    const GpuEngine& engine() const { return engine_; }
    const Work& uploadWork() const { return upload_; }

  private:
    Scene scene_;
    Budgets& budgets_;
    Planner prepared_;
    Work upload_;
    GpuEngine engine_; // after the plan, which it draws
};

/// Slices from memory, so that an import is timed without its source.
class MemorySource : public SlabSource {
  public:
    /// @param voxels  [z][y][x], outlives this
    MemorySource(const VolumeInfo& info, const std::vector<std::byte>& voxels)
        : info_(info), voxels_(voxels) {}
    const VolumeInfo& info() const override { return info_; }
    void readSlices(int count, std::span<std::byte> out) override;
    std::string describe() const override { return "a volume in memory"; }

  private:
    VolumeInfo info_;
    const std::vector<std::byte>& voxels_;
    std::size_t next_ = 0; // byte
};

/// A whole generated volume in memory, its values converted to a type.
struct MemoryVolume {
    VolumeInfo info;
    std::vector<std::byte> voxels;
};
MemoryVolume phantomInMemory(const std::string& name, const glm::ivec3& extent, ValueType type);

/// "--name value" pairs. Throws InputError for a name that is not among the defaults, or has no value.
std::map<std::string, std::string> parseOptions(int argc, char** argv,
                                                std::map<std::string, std::string> defaults);
/// "1,2,3"; throws InputError naming option for anything but positive numbers.
std::vector<double> parseNumbers(const std::string& text, const std::string& option);
/// "512x512x749"; throws InputError naming option.
glm::ivec3 parseExtent(const std::string& text, const std::string& option);

/// Imports a phantom to `store` unless something is there already.
void ensurePhantomStore(const std::filesystem::path& store, const std::string& name,
                        const glm::ivec3& extent);

/// Load average of the last minute, or -1: to be printed beside every time.
double loadAverage();

} // namespace tessera::bench
