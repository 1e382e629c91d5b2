// render/plan/frame_plan.h: FramePlan: everything that a renderer needs of a scene and its volumes. Renderers
// read it; a Planner (planner.h) makes it, and makes it again when something is learnt.
#pragma once

#include "bricking/analysis/body/table_mask.h"
#include "bricking/cache/brick_cache.h"
#include "bricking/levels/selection.h"
#include "bricking/mask/masked_source.h"
#include "bricking/statistics/local_histograms.h"
#include "bricking/statistics/statistics.h"
#include "bricking/store/store_reader.h"
#include "core/base/budget.h"
#include "core/base/volume.h"
#include "core/scene/camera.h"
#include "core/scene/exposure.h"
#include "core/scene/mode.h"
#include "core/scene/preset.h" // ValueSummary
#include "core/scene/scene.h"
#include "core/scene/transfer_function.h"
#include "render/contract/level_map.h"
#include "render/contract/optics.h"
#include "render/contract/ray.h"
#include "render/contract/strides.h"
#include "render/empty_space/distance_map.h" // MapScale
#include "render/empty_space/extinction_bounds.h"
#include "render/empty_space/occupancy.h"
#include "render/empty_space/value_bounds.h"
#include "render/geometry/mesh_bits.h"
#include "render/labels/label_field.h"
#include "render/light/shadow_maps.h" // ShadowQuality
#include "render/plan/choose_levels.h"
#include "render/plan/drawn_part.h"
#include "render/residency/pages.h"

#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace tessera {

class SliceLabels;
struct SharedVolume;

// The state of the view: camera, picture, step, and revisions for data derived from it.

struct ViewState {
    Camera camera;
    glm::ivec2 imageSize{0};
    glm::ivec2 mostTogether{0}; // of a picture that is drawn part by part: the largest part; else 0
    Quality quality;            // current step, sampling and fetch; the requested integrator
    RayFrame<double> frame;
    DrawnPart part;        // of the volume
    Lighting lighting;     // the scene's, as are the next two
    Lighting pathLighting; // where light follows paths: the scene's with what light per voxel would be
    Shading shading;
    std::vector<Isosurface> surfaces;
    std::vector<SceneMesh> meshes;            // those that are drawn
    std::shared_ptr<const MeshBits> meshBits; // where they occlude surfaces; else null
    std::optional<Exposure> exposure;         // where rays show sums; else none
    bool reflects = false;                    // isosurfaces mirror or refract rays: a still's
    glm::vec3 background{0};                  // what reflections see beyond the volume
    bool meshesShade = true;                  // the volume's shadow maps hold them
    bool amongOthers = false;                 // of one of several volumes
    ShadowQuality shadowQuality;
    Charge imageCharge; // pictures and ray states, in RAM

    /// Of sampling by hulls, their number settled; else none: count 0.
    Hulls hulls() const;
    /// The pixels that are drawn together: the picture's, or a part's.
    glm::ivec2 drawnSize() const { return mostTogether.x > 0 ? mostTogether : imageSize; }
};

/// Of rays; count 0: they have none.
inline Hulls hullsOf(const RayFrame<double>& frame) {
    return frame.hulls.count > 0 ? Hulls{frame.hulls.count, frame.hulls.samples} : Hulls{0, 0};
}

/// The parts that can change between two pictures.
enum Change : std::uint32_t {
    kCameraChanged = 1u << 0,
    kFunctionChanged = 1u << 1,
    kLevelsChanged = 1u << 2,     // of bricks
    kEmptySpaceChanged = 1u << 3, // its map
    kLightChanged = 1u << 4,      // of voxels
};

/// Changes since the last check: each consumer of a scene keeps one.
class Changes {
  public:
    explicit Changes(std::uint32_t changes = 0) : bits_(changes) {}
    void add(std::uint32_t changes) { bits_ |= changes; }
    bool any(std::uint32_t changes) const { return (bits_ & changes) != 0; }
    bool any() const { return bits_ != 0; }
    /// Returns true if there were any of these, and clears them.
    bool take(std::uint32_t changes) {
        const bool were = any(changes);
        bits_ &= ~changes;
        return were;
    }

  private:
    std::uint32_t bits_;
};

// The memory plan: the list of a scene's needs from both budgets besides its bricks. Minimum memory (a floor)
// is always taken. Optional memory (a luxury) is granted if it is a small part of what minimum memory leaves.

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
/// The RAM of pixels, and which are drawn together.
struct PixelMemory {
    std::size_t bytesPerPixel = kPictureBytesPerPixel; // that the engine and its caller take
    glm::ivec2 most{
        0}; // of a picture that is drawn part by part: the largest part; 0: it is drawn as a whole

    PixelMemory(std::size_t bytes, const glm::ivec2& together = glm::ivec2(0)) // implicit: a whole picture's
        : bytesPerPixel(bytes), most(together) {}
    PixelMemory() = default;
    /// The pixels that are drawn together.
    glm::ivec2 of(const glm::ivec2& picture) const { return most.x > 0 ? glm::min(most, picture) : picture; }
};
/// RAM of a selection: levels and means.
std::size_t selectionBytes(const VolumeInfo& info);

/// The scene's minimum RAM, with its store reader: no smaller budget is accepted, and this one suffices.
/// @param threads  0: all processors
std::size_t renderFloorBytes(const VolumeInfo& info, const glm::ivec2& imageSize, std::size_t bytesPerPixel,
                             int threads, Integrator integrator = Integrator::automatic);

// The data of one volume for pictures by any engine: statistics, resolved transfer function, a level for
// every brick, occupancy, and the chunk cache.

struct Layer {
    const StoreReader* store = nullptr;       // outlives this
    std::unique_ptr<MaskedSource> masked;     // the store without what the scene hides; null: all is shown
    std::unique_ptr<MaskedSource> unlabelled; // that without hidden labels, where rays keep one value
    std::optional<TableReport> patientTable;  // where the scene may hide it
    std::unique_ptr<DrawnLabels> labels;      // null: the scene has none
    std::unique_ptr<LabelBricks> labelBricks; // of these; in RAM
    std::shared_ptr<SliceLabels> sliceLabels; // over the values of a slice; null: not drawn
    std::uint32_t hidden = 0;                 // tells what masked hides; 0: nothing
    Statistics statistics;
    std::shared_ptr<const LocalHistograms> histograms; // where occlusion is by them; else null
    TransferFunction function;
    TransferTable table;
    TransferTable body; // what a radiograph's camera is fitted to; else empty
    Optics optics;
    Selection selection;
    int pageEdge = kBrickExtent; // samples along a page of bricks, ghost layers included
    LevelMap levels;             // of a selection of mixed levels; else empty
    MapScale mapScale = MapScale::bricks;
    Occupancy occupancy; // and the distance map; none if rays keep one value
    ValueLook look;      // of single values, if they do
    bool addsUp = false; // rays show sums of it (core/scene/exposure.h)
    ValueBounds bounds;  // then: bounds for leaps of rays that keep the maximum or minimum
    /// Occupancy of isosurfaces alone: a separate map, if there are surfaces, the function is visible too,
    /// and memory suffices.
    bool mapsSurfaces = false;
    Occupancy surfaceOccupancy;
    TransferTable surfaceTable;  // then
    ExtinctionBounds extinction; // where light follows paths
    Charge selectionCharge;
    Charge functionCharge;             // the transfer function's table, twice
    Charge lightCharge;                // memory for computing light per voxel
    std::unique_ptr<BrickCache> cache; // last member: destroyed first, because its threads read the store

    const VolumeInfo& info() const { return store->info(); }
    /// What is drawn.
    const ChunkSource& voxels() const {
        if (unlabelled)
            return *unlabelled;
        return masked ? static_cast<const ChunkSource&>(*masked) : *store;
    }
    /// What cameras are fitted to.
    const TransferTable& shownTable() const { return body.entries.empty() ? table : body; }
    bool mixed() const { return !levels.corners.empty(); }
    /// True if rays keep one value instead of compositing.
    bool reduces() const { return optics.reduction != Reduction::composite; }
    /// The labels' own medium is drawn.
    bool showsMedium() const { return labels && labels->showsMedium(); }
    /// Updates occupancy for the selection's levels; computes all of it the first time.
    void mapEmptySpace(const Quality& quality, MemoryBudget& ram);
    /// Updates occupancy for a new table.
    void functionChanged(const Quality& quality, MemoryBudget& ram, int threads);
};

/// Statistics of a volume for presets.
ValueSummary summarise(const Statistics& statistics, const VolumeInfo& info, const std::string& unit = "");

/// The edge of a cube with a voxel's volume.
double typicalVoxelMm(const VolumeInfo& info);

/// Numbers that are never the same for two states of a part of any plan: who keeps something made from that
/// part compares them before rays begin.
struct PlanRevisions {
    std::uint64_t function = 0;   // transfer function, materials, lights
    std::uint64_t tables = 0;     // of the function, for the integrator and the step; where rays end
    std::uint64_t levels = 0;     // of bricks, and their map
    std::uint64_t emptySpace = 0; // its maps

    static std::uint64_t next();
};

/// The layers of a plan. They stay where they are when another plan takes this one's place, because light
/// that renderers keep from frame to frame refers to their statistics and tables.
class Layers {
  public:
    Layers() { all_.push_back(std::make_unique<Layer>()); }
    Layers(Layers&& other) noexcept : all_(std::move(other.all_)) {}
    Layers& operator=(Layers&& other) noexcept;
    Layer& front() { return *all_.front(); }
    const Layer& front() const { return *all_.front(); }

  private:
    std::vector<std::unique_ptr<Layer>> all_; // one: further volumes have plans of their own
};

struct FurtherVolume;

/// A plan's further volumes (fusion.h).
class FurtherVolumes {
  public:
    FurtherVolumes();
    FurtherVolumes(FurtherVolumes&&) noexcept;
    FurtherVolumes& operator=(FurtherVolumes&&) noexcept;
    ~FurtherVolumes();
    void add(std::unique_ptr<FurtherVolume> volume);
    std::size_t size() const { return all_.size(); }
    FurtherVolume& operator[](std::size_t number) const { return *all_[number]; }
    auto begin() const { return all_.begin(); } // pointers
    auto end() const { return all_.end(); }

  private:
    std::vector<std::unique_ptr<FurtherVolume>> all_;
};

/// Several volumes under the same rays.
struct FusedLattice {
    Fusion rule = Fusion::mix;
    VolumeInfo voxels;         // and the box of rays
    glm::dmat4 fromLattice{1}; // the first volume's voxels from its places
    OwnCuts cuts;              // of the first volume alone
    DrawnPart part;            // of that box
};

struct FramePlan {
    ViewState view;
    MemoryPlan memory;
    ChosenLevels chosen; // report of the choice of levels; the selection itself has moved to the layer
    PlanRevisions revisions;
    Integrator mayTake = Integrator::midpoint; // the largest that is taken without being named
    /// The first volume. Its cache goes first, after those of the others.
    Layers layers;
    /// Processes draw the volume together (render/parts/process_group.h); null: this one draws all of it.
    std::shared_ptr<const SharedVolume> shared;
    std::optional<FusedLattice> fused; // none: every volume has rays of its own
    FurtherVolumes further;            // the others

    /// How many volumes the plan's rays go through.
    std::size_t volumesOfRays() const { return fused ? 1 + further.size() : 1; }

    const Layer& layer() const { return layers.front(); }
    const VolumeInfo& info() const { return layer().info(); }
    /// The voxels that rays count in.
    const VolumeInfo& rayVoxels() const { return fused ? fused->voxels : info(); }
    /// Those worth trying on some pixels: one, where the function leaves no doubt or the scene names it.
    std::vector<Integrator> integratorsToTry() const;
    /// GPU memory of a function's tables, whichever integrator it may come to.
    std::size_t gpuTableBytes(std::size_t entries) const;
    /// Valid as long as the plan is there, moved or not.
    Strides strides() const;
    /// Planes of 16-bit samples that engines keep beside the values: light, and labels.
    int channelsBeside() const;

  protected:
    Integrator automaticIntegrator() const;
    Integrator preintegration() const;
};

} // namespace tessera
