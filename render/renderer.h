// render/renderer.h: Renderer: a plan in, a frame out. All ray backends (engine.h) are drawn by one renderer,
// picture/ray_renderer.h; a renderer without rays is a sibling of it. A folder of render/backends/ brings
// either: its EngineTraits name it, and cmake/Backend.cmake makes the table of all.
#pragma once

#include "bricking/levels/selection.h" // kLevelCount
#include "core/base/progress.h"
#include "core/base/work.h"
#include "core/image/image.h"
#include "core/scene/camera.h"
#include "core/scene/mode.h"
#include "core/scene/preset.h" // FillValue
#include "core/scene/scene.h"
#include "render/backends/gpu/gl/context.h"
#include "render/contract/ray_state.h"
#include "render/engine.h"
#include "render/engine_traits.h"
#include "render/light/reflections.h"
#include "render/light/scene_light.h"
#include "render/light/surface_light.h"
#include "render/picture_tiles.h"
#include "render/pixels/area_picture.h"
#include "render/pixels/picture_layers.h"
#include "render/plan/choose_levels.h"
#include "render/plan/frame_context.h"
#include "render/plan/frame_plan.h"
#include "render/plan/planner.h"
#include "render/plan/step_search.h"
#include "render/verify/verify_plan.h"

#include <array>
#include <cstdint>
#include <functional>
#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tessera {

class KeptSamples;

// The options of a picture besides its scene, and its result.

struct RenderOptions {
    EngineKind engine = EngineKind::automatic;
    GlDeviceChoice device;
    int threads = 0;      // CPU engines and loaders; 0: all processors
    Slicing slicing;      // gpu and native
    bool counting = true; // work counters; false: not compiled
    LevelChoice levels = LevelChoice::perBrick;
    int shadowLayers = DeepShadowMap::kLayers; // points of a shadow map's ray, 2 to DeepShadowMap::kLayers
    bool searching = false;                    // gpu and native: choose the step if the scene names none
    bool checking = false;                     // the same, and estimate the errors of step and filtering
    Verify verify = Verify::none;              // gpu and native: measure the picture's errors
    /// Engines gpu and native: called with a first picture, all bricks at one coarse level, before levels are
    /// chosen for the picture itself. It also gets an estimate, good to a factor of three, of the remaining
    /// seconds.
    std::function<void(const Image&, double)> onFirstPicture;
    /// Where light follows paths: called with the picture so far when pixels have 1, 2, 4, ... samples,
    /// before the last, and with their number and the standard error (rms; one sample tells none).
    std::function<void(Image, int samples, std::optional<double> noise)> onRound;
    Progress* progress = nullptr; // none: silent
    LayersAsked layers;           // besides the colour
    /// Where sums of samples are kept for a later run, and where they are taken from; null: nowhere. Of
    /// scenes with a transport, whose samples are a number from 2 on.
    KeptSamples* kept = nullptr;
    /// The picture is drawn tile by tile, and kept there: the result has no image. Null: as a whole. Neither
    /// of pixels that decide about their samples, nor of what needs all pixels: maxError with a measurement,
    /// noise, denoise, layers, kept samples, first pictures, labels over a slice.
    PictureTiles* tiles = nullptr;
    /// Draws the picture together with others, each of them a part of the volume; null: alone. All have the
    /// same scene and options, and get the whole picture. Of engines that draw parts; neither in tiles, nor
    /// with a first picture, a measurement, or what checkShared() refuses.
    ProcessGroup* group = nullptr;
    /// Of a slice with labels: shares by which pixels are multiplied before labels are laid over them;
    /// null: 1. Of the scene's size, and alive as long as the picture is drawn.
    const std::vector<float>* shares = nullptr;
};

struct RenderResult {
    Image image;   // linear, premultiplied, without background: composite it over the scene's to show it
    Camera camera; // as used, with a fitted view resolved
    Work work;
    EngineKind engine = EngineKind::automatic;                // that drew it; never automatic
    std::string engineReason;                                 // reason; empty if it was requested
    std::string device;                                       // GL_RENDERER, or "CPU"
    std::string glVersion;                                    // "" for CPU engines
    int level = 0;                                            // finest resident level; 0 for the reference
    std::array<std::size_t, kLevelCount + 1> bricksOfLevel{}; // the last: empty ones
    std::size_t residentBricks = 0, emptyBricks = 0;
    std::size_t unseenBricks = 0; // bricks without any ray near them; neither resident nor counted as empty
    std::optional<LightReport> light;                 // light per voxel, if the scene has any
    std::optional<SurfaceLight::Report> surfaceLight; // occlusion of surfaces, if it has any
    std::optional<Reflections::Report> reflections;   // of surfaces, if they reflect
    std::size_t selectionPages = 0, atlasPages = 0;   // of 32^3 texels: wanted, and resident at once
    int passes = 0;                                   // over the rays; gpu and native
    bool levelsOnPurpose = false;                     // one level for all was requested
    std::optional<PredictedError>
        predictedError; // L*u*v*, of the levels against the finest that a pixel shows
    std::size_t cells = 0, occupiedCells = 0, refinedCells = 0;
    std::uint32_t features = 0; // of render/backends/gpu/features.h; gpu only
    double tableRelativeError = 0;
    Integrator integrator = Integrator::midpoint; // as used, as is the step
    double stepVoxels = 0;
    Hulls hulls{0, 0};                          // of the rays; count 0: none
    std::optional<double> stepOfMeans;          // step of pixels with eight or more rays; voxels
    std::optional<PictureErrors> errors;        // if they were checked
    std::optional<PictureMeasurement> measured; // if requested
    int rounds = 1;                             // pictures drawn until the error bound was met
    std::string shortfall;                      // reason if it is not; empty: it is, or no bound was given
    PixelReport pixels;
    std::optional<PictureLayers> layers; // LayersAsked::paths
    std::optional<Image> pixelErrors;    // LayersAsked::errors, where pixels have several samples
    double secondsChecking = 0;
    GreyWindow window;                       // as used, in modes that show single values
    double lowest = 0, highest = 0;          // values of the volume, physical units
    std::vector<FillValue> leftOut;          // fill values, where the function or the window adapts to values
    std::optional<TableReport> patientTable; // where the scene may hide it
    struct Labels {
        std::size_t all = 0, shown = 0; // labels of the file; of them those that are drawn
        int channels = 0;               // planes of 16 bits a sample beside the values
        /// Over a slice: of each volume, the values of the labels that lie on it, and the level of their
        /// voxels.
        std::vector<std::vector<std::uint32_t>> onSlice = {};
        int level = 0;
        std::size_t countOnSlice() const {
            std::size_t count = 0;
            for (const auto& values : onSlice)
                count += values.size();
            return count;
        }
    };
    std::optional<Labels> labels; // where the scene has them
    /// A volume besides the first. Bricks above are those of all volumes.
    struct Further {
        int level = 0; // finest resident
        std::array<std::size_t, kLevelCount + 1> bricksOfLevel{};
        std::size_t ramBytes = 0, ramPeakBytes = 0, gpuBytes = 0, gpuPeakBytes = 0; // its shares
    };
    std::vector<Further> further;
    PartTree::Box part;      // of the volume, bricks, where processes share it: this one's
    glm::ivec3 rayExtent{0}; // with several volumes: the box of their rays, voxels
    bool takenAsHu = false;  // taken for HU by a preset, by their distribution
    double secondsPreparing = 0, secondsLoading = 0, secondsDrawing = 0;
};

/// A round of pictures of one scene that come nearer and nearer to the request.
struct Round {
    int number = 0; // from 0
    PixelGoal goal; // if pixels decide the number of their samples
};

/// Of pictures that follow one another.
struct FrameReuse {
    bool kept = false;            // the renderer holds the bricks of the picture before
    std::size_t pages = 0;        // to take, so that the next pictures' bricks have room; 0: the plan's
    std::function<void()> opened; // the renderer has its RAM
    bool first = false;           // a first, coarse picture: without occlusion of surfaces
};

/// A frame to be drawn; all of it outlives the call.
struct FrameTask {
    const Scene& scene;
    Planner& plan; // takes the step and integrator that pixels were tried for, and levels by visibility
    const FrameContext& context;
    const RenderOptions& options;
    Round round = {};
    FrameReuse reuse = {};
};

/// Pixels of the frame just drawn, again: for measured errors.
class PixelSource {
  public:
    virtual ~PixelSource() = default;

    struct About {
        bool finest = false; // the frame had the finest levels
        bool passes = false; // it took its bricks in several passes
        int brickPixels = 1; // a brick's width in the middle of the volume
    };
    virtual About about() const = 0;
    /// The colours of samples through places, at their end.
    /// @param places  in pixels of the picture, row by row of an array of arraySize, as Rays::places
    /// @param mostBytes  of bricks that may be loaded, for all work together; none if they would take more
    virtual std::optional<Image> draw(std::span<const glm::vec2> places, const glm::ivec2& arraySize,
                                      const Slicing& slicing, std::uint64_t mostBytes, Work& work) = 0;
    /// Until toTruth() draw() tells the frame with the light that planes, maps and a number of rays stand
    /// for, by single ways of it, whose mean has no error (docs/sampling.md, "Paths", contract). Returns why
    /// it cannot; empty: it does.
    virtual std::string toSingleWays() { return "this renderer follows no paths of light"; }
    /// From here on draw() tells the true integral, through the finest level.
    /// Returns why it cannot; empty: it does.
    virtual std::string toTruth() = 0;
};

class Renderer {
  public:
    virtual ~Renderer() = default;

    virtual Engine::About about() const = 0;
    virtual TextureLimits limits() const { return {}; }
    /// Draws the plan's frame, and tells it and its causes in the result: the picture in result.image, light
    /// that is added once errors are known in `added`.
    /// Returns whether it went on from the samples of the round before.
    virtual bool draw(const FrameTask& task, RenderResult& result, Image& added) = 0;
    /// Of the frame just drawn, and valid until the next; null: its errors cannot be measured.
    /// @param task  that of the frame; outlives the result
    virtual std::unique_ptr<PixelSource> pixels(const FrameTask& task) {
        (void)task;
        return nullptr;
    }
    /// Releases memory of the last frame that the next does not need; bricks stay.
    virtual void endFrame() {}
    /// Releases the plan and all that was made from it.
    virtual void close() {}
    /// Of bricks that are kept from frame to frame; null where there are none.
    virtual BrickResidency* bricks() { return nullptr; }
    /// The errors since the last call that nothing reported; empty: none.
    virtual std::string fault() { return {}; }
};

// The entries of a picture's result that any plan gives.

/// The fill values that the scene's function or window leaves out because it adapts to the values.
std::vector<FillValue> fillsLeftOut(const Scene& scene, const ValueSummary& values);

/// Camera, values, window and cells of the plan's volume.
void reportVolume(const FramePlan& plan, const Scene& scene, RenderResult& result);

/// Levels, bricks, pages, integrator and step; once they are final. Bricks that no ray meets count as empty.
void reportLevels(const FramePlan& plan, RenderResult& result);

} // namespace tessera
