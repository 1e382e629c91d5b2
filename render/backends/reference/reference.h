// render/backends/reference/reference.h: the true volume rendering integral of the finest level, in double,
// cell by cell. It is slow; reported errors are differences to it. It reads the transfer function's points,
// not the table, and has no levels, empty bricks or steps. Isosurfaces are at the roots of the field's
// cubics.
#pragma once

#include "bricking/cache/brick_cache.h"
#include "bricking/statistics/statistics.h"
#include "core/base/progress.h" // ShareDone
#include "core/base/volume.h"
#include "core/scene/camera.h"
#include "core/scene/mode.h"
#include "core/scene/scene.h"
#include "core/scene/transfer_function.h"
#include "render/contract/ray_cuts.h"
#include "render/labels/label_field.h"
#include "render/plan/frame_plan.h"
#include "render/transport/traced_path.h"

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>
#include <limits>
#include <span>
#include <vector>

namespace tessera {

struct ReferenceInput {
    BrickCache* cache = nullptr;
    const VolumeInfo* info = nullptr;
    const TransferFunction* function = nullptr;
    Shading shading;
    /// Optional: cells of 8^3 voxels without extinction and isosurface are passed in one stride.
    const Statistics* statistics = nullptr;
    /// Initial panels of a smooth piece of a ray, at least 1. More panels change the result only by rounding,
    /// as the verification checks (reference_proof.h).
    int panels = 1;
    std::vector<Isosurface> surfaces = {}; // of the scene
    ShareDone progress = {};
    Lighting lighting = {}; // of the scene
    Camera camera = {};     // for lights fixed to it
    /// Tolerance of shares of light along a ray, for occlusion or shadows: the error of a pixel's light is at
    /// most about twice this share (light_between.h).
    double lightTolerance = 1e-3;
    /// Of rays that keep one value: the extrema of the field itself, or its mean along the ray.
    Reduction reduction = Reduction::composite;
    ValueLook look = {};
    /// Extinctions are so many times those that show (core/scene/exposure.h): the scale of tolerances.
    double thinness = 1;
    /// The drawn part is inside of all slabs; in voxels.
    std::vector<RaySlab<double>> slabs = {};
    bool flat = false;                      // one slab is a plane, at which a ray has one value
    const RayCuts* cuts = nullptr;          // other cuts
    LabelBricks* labels = nullptr;          // of the scene; null: it has none
    std::span<const SceneMesh> meshes = {}; // that take light from the volume
    /// Of rays through several volumes, this and the further ones: their lattice, in whose voxels rays, slabs
    /// and cuts are. Null: the volume is alone.
    const FusedLattice* fused = nullptr;
    glm::dmat4 fromLattice{1};
    /// Colours are those of paths of light, one a ray; null: they are the integral's.
    const PathScene* paths = nullptr;
    std::span<const PathStart> starts = {}; // of these, one a ray
    const RayCuts* ownCuts = nullptr;       // of this volume alone, in its voxels; null: it is alone
    std::vector<ReferenceInput> further = {};
    bool reflects = false; // rays keep their first hits among isosurfaces with a reflection
};

/// A ray in voxel space with a parameter in mm: p(t) = base + t * direction, t in [tMin, tMax].
struct ReferenceRay {
    glm::dvec3 base{0}, direction{0}; // voxels; voxels per mm
    double tMin = 0;                  // mm
    double tMax = std::numeric_limits<double>::max();
};

/// The camera's rays, row by row from the top left pixel, through pixel centres.
/// @param stride  only rays of thinned() pictures (core/image/image.h)
/// @param shift  moves each ray in its pixel, pixels right and down
std::vector<ReferenceRay> referenceRays(const Camera& camera, const VolumeInfo& info, const glm::ivec2& size,
                                        int stride = 1, const glm::dvec2& shift = glm::dvec2(0));

/// The camera's rays through points on the picture, in pixels.
std::vector<ReferenceRay> referenceRays(const Camera& camera, const VolumeInfo& info, const glm::ivec2& size,
                                        std::span<const glm::vec2> places);

/// Optics for lighting alone, without a table.
struct Optics;
Optics shadingOf(const ReferenceInput& input);

/// Premultiplied colour and alpha per ray. Bit-equal at any number of threads.
std::vector<glm::dvec4> renderReference(const ReferenceInput& input, const std::vector<ReferenceRay>& rays,
                                        int threads);

} // namespace tessera
