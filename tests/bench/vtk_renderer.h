// tests/bench/vtk_renderer.h: VTK's two volume mappers behind one interface, set up for an equal comparison
// as VTK's users do. Nothing is adaptive or random, and camera, transfer function and light are the same. All
// calls come from one thread; the GL context is VTK's own.
//
// Light. VTK's highlight is pow(n.h, power), h half way between light and eye; ours is pow(r.v, power). With
// a head light both depend on the angle between normal and eye, as cos(a)^p' and cos(2a)^p. These are alike
// for p' = 4p (they differ by at most 0.007 at a power of 20), so VTK gets four times the power. The CPU
// mapper has one direction of light and of view for a whole picture, which is right for a head light in
// parallel projection only. The GPU mapper takes its head light from the camera's position, also in parallel
// projection, so the camera is far away then.
#pragma once

#include "bricking/store/store_reader.h"
#include "core/base/volume.h"
#include "core/image/image.h"
#include "core/scene/camera.h"
#include "core/scene/scene.h" // Shading
#include "core/scene/transfer_function.h"

#include <cstddef>
#include <glm/vec2.hpp>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace tessera::bench {

/// Every level-0 voxel, for VTK, which holds volumes whole.
std::vector<std::byte> wholeVolume(const StoreReader& store);

enum class VtkMapper { cpu, gpu }; // vtkFixedPointVolumeRayCastMapper, vtkOpenGLGPUVolumeRayCastMapper

class VtkRenderer {
  public:
    /// @param voxels  all voxels of level 0 as stored, [z][y][x]; not copied, outlives this
    /// Throws InputError for a volume whose axes are not along the patient's.
    VtkRenderer(VtkMapper mapper, const VolumeInfo& info, std::span<const std::byte> voxels,
                const TransferFunction& function, const Shading& shading, const Camera& camera,
                const glm::ivec2& size);
    ~VtkRenderer();
    VtkRenderer(const VtkRenderer&) = delete;
    VtkRenderer& operator=(const VtkRenderer&) = delete;

    /// Milliseconds of one frame: render, wait for it, read 8-bit RGBA back. The first frame, and with the
    /// CPU mapper the first one at every other distance, is drawn twice and timed once. Its uploads, tables
    /// and normals count for the scene, not for a frame.
    double drawMs(double sampleDistanceMm);
    /// The last frame. VTK's 8-bit values are taken as linear, as the transfer function's colours went in.
    Image picture() const;
    /// OpenGL renderer and version of VTK's window.
    std::string device() const;
    static std::string version();

  private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace tessera::bench
