// render/plan/memory_plan.h: the memory plan: the list of a scene's needs from both budgets besides its
// bricks. Minimum memory (a floor) is always taken. Optional memory (a luxury) is granted if it is a small
// part of what minimum memory leaves.
#pragma once

#include "core/base/budget.h"
#include "core/base/volume.h"
#include "core/scene/scene.h"
#include "render/empty_space/distance_map.h" // MapScale
#include "render/residency/pages.h"

#include <cstddef>
#include <glm/vec2.hpp>
#include <string>
#include <vector>

namespace tessera {

struct Need {
    const char* what = "";
    std::size_t ramBytes = 0, gpuBytes = 0;
};

class MemoryPlan {
  public:
    MemoryPlan() = default;
    /// @param spareRam, spareGpu  base of the shares of optional memory: what minimum memory and bricks leave
    MemoryPlan(std::size_t spareRam, std::size_t spareGpu) : spareRam_(spareRam), spareGpu_(spareGpu) {}

    void setSpare(std::size_t ramBytes, std::size_t gpuBytes) {
        spareRam_ = ramBytes;
        spareGpu_ = gpuBytes;
    }
    void need(const char* what, std::size_t ramBytes, std::size_t gpuBytes) {
        needs_.push_back({what, ramBytes, gpuBytes});
    }
    /// Grants optional memory if it is at most one part in `parts` of the spare memory; a replaced need is
    /// given back. Returns true if granted.
    /// @param replaces  name of a need, or null
    bool grant(const char* what, std::size_t ramBytes, std::size_t gpuBytes, std::size_t ramParts,
               std::size_t gpuParts, const char* replaces = nullptr);

    /// GPU memory besides bricks; RAM that must stay free for later allocations.
    std::size_t gpuBytes() const;
    std::size_t ramBytes() const;

  private:
    std::size_t spareRam_ = 0, spareGpu_ = 0;
    std::vector<Need> needs_;
};

/// RAM of a transfer function's tables: in TransferTable and Optics, sums, and the tables of colours with the
/// copy for an upload.
std::size_t tableRamBytes(std::size_t entries, Integrator integrator);
/// GPU memory of the same tables, and the part of it for integrators other than midpoint.
std::size_t tableGpuBytes(std::size_t entries, Integrator integrator);
std::size_t integratorGpuBytes(std::size_t entries, Integrator integrator);

/// RAM allocated once the camera is known: the level map, the distance map, the smallest cache and staging
/// for uploads.
/// @param threads  0: all processors
std::size_t ramAfterCamera(const VolumeInfo& info, int threads, MapScale scale, bool skipping);

/// RAM per pixel for drawing and writing: two float pictures (as computed, and converted or on its
/// background) and the encoded one.
constexpr std::size_t kPictureBytesPerPixel = 2 * sizeof(glm::vec4) + 4 * sizeof(std::uint16_t);
/// RAM of a selection: levels and means.
std::size_t selectionBytes(const VolumeInfo& info);

/// The scene's minimum RAM, with its store reader: no smaller budget is accepted, and this one suffices.
/// @param threads  0: all processors
std::size_t renderFloorBytes(const VolumeInfo& info, const glm::ivec2& imageSize, std::size_t bytesPerPixel,
                             int threads, Integrator integrator = Integrator::automatic);

} // namespace tessera
