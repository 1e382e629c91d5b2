// render/render_result.h: the options of a picture besides its scene, and its result.
#pragma once

#include "bricking/levels/selection.h" // kLevelCount
#include "core/base/progress.h"
#include "core/base/work.h"
#include "core/image/image.h"
#include "core/scene/camera.h"
#include "core/scene/mode.h"
#include "render/backends/gpu/gl/device_choice.h"
#include "render/contract/slicing.h"
#include "render/engine_traits.h"
#include "render/light/scene_light.h"
#include "render/light/surface_light.h"
#include "render/pixels/area_picture.h"
#include "render/plan/choose_levels.h"
#include "render/plan/picture_check.h"
#include "render/verify/picture_measurement.h"
#include "render/verify/verify_plan.h"

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

namespace tessera {

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
    Progress* progress = nullptr; // none: silent
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
    std::optional<double> stepOfMeans;          // step of pixels with eight or more rays; voxels
    std::optional<PictureErrors> errors;        // if they were checked
    std::optional<PictureMeasurement> measured; // if requested
    int rounds = 1;                             // pictures drawn until the error bound was met
    std::string shortfall;                      // reason if it is not; empty: it is, or no bound was given
    PixelReport pixels;
    double secondsChecking = 0;
    GreyWindow window;              // as used, in modes that show single values
    double lowest = 0, highest = 0; // values of the volume, physical units
    bool takenAsHu = false;         // taken for HU by a preset, by their distribution
    double secondsPreparing = 0, secondsLoading = 0, secondsDrawing = 0;
};

} // namespace tessera
