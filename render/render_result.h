// render/render_result.h: how a picture is asked for besides its scene, and everything that is told of one.
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
    bool counting = true; // work counters; false: they are not compiled
    LevelChoice levels = LevelChoice::perBrick;
    int shadowLayers = DeepShadowMap::kLayers; // that shadow maps keep of a ray, 2 to so many
    bool searching = false; // gpu and native: take a step that is good enough, where the scene names none
    bool checking = false;  // the same, and estimate what steps and filtering cost the picture
    Verify verify = Verify::none; // gpu and native: measure the picture's errors
    /// Gpu and native: gets a first whole picture, all bricks at one coarse level, before levels are chosen
    /// and loaded for the picture itself. It also gets an estimate, good to a factor of three, of the seconds
    /// that the rest takes.
    std::function<void(const Image&, double)> onFirstPicture;
    Progress* progress = nullptr; // none: says nothing
};

struct RenderResult {
    Image image;   // linear, premultiplied, on nothing: put it on the scene's background to show it
    Camera camera; // as used: a fitted view spelled out
    Work work;
    EngineKind engine = EngineKind::automatic;                // that drew it: never automatic
    std::string engineReason;                                 // why; empty where it was asked for
    std::string device;                                       // GL_RENDERER, or "CPU"
    std::string glVersion;                                    // "" for CPU engines
    int level = 0;                                            // finest resident level; 0 for the reference
    std::array<std::size_t, kLevelCount + 1> bricksOfLevel{}; // the last: empty ones
    std::size_t residentBricks = 0, emptyBricks = 0;
    std::size_t unseenBricks = 0;     // no ray comes near them; neither resident nor counted as empty
    std::optional<LightReport> light; // of voxels, where the scene has any
    std::optional<SurfaceLight::Report> surfaceLight; // occlusion of surfaces, where it has any
    std::size_t selectionPages = 0, atlasPages = 0;   // of 32^3 texels: wanted, and there at once
    int passes = 0;                                   // over the rays; gpu and native
    bool levelsOnPurpose = false;                     // one level for all was asked for
    std::optional<PredictedError> predictedError; // L*u*v*, of the levels against the finest a pixel shows
    std::size_t cells = 0, occupiedCells = 0, refinedCells = 0;
    std::uint32_t features = 0; // of render/backends/gpu/features.h; gpu only
    double tableRelativeError = 0;
    Integrator integrator = Integrator::midpoint; // as used; so the step
    double stepVoxels = 0;
    std::optional<double> stepOfMeans;          // of rays of which a pixel takes eight or more; voxels
    std::optional<PictureErrors> errors;        // where they were checked
    std::optional<PictureMeasurement> measured; // where it was asked for
    int rounds = 1;                             // pictures drawn until the error was what was asked for
    std::string shortfall;                      // why it is not; empty: it is, or none was asked for
    PixelReport pixels;
    double secondsChecking = 0;
    GreyWindow window;              // as used, in modes that show single values
    double lowest = 0, highest = 0; // values of the volume, physical units
    bool takenAsHu = false;         // by a preset, because they look like HU: nobody said so
    double secondsPreparing = 0, secondsLoading = 0, secondsDrawing = 0;
};

} // namespace tessera
