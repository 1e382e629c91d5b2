// tests/bench/accuracy/sweep.h: one scene drawn in every planned setting: the distance of each picture from
// the true integral, its cost in counts and in time, and what went wrong.
#pragma once

#include "core/base/work.h"
#include "core/image/image_metrics.h"
#include "render/backends/reference/reference_proof.h"
#include "render/picture/render_scene.h"
#include "tests/bench/accuracy/setting.h"
#include "viewer/cli/options/options.h"

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace tessera::accuracy {

/// A scene under a public name; its volume is a store.
struct NamedScene {
    std::string name;  // also of its files: letters, digits, dashes
    std::string about; // what is shown, a sentence; no paths
    Scene scene;
    std::size_t gpuBytes = 0; // a budget of its own; 0: the one of all scenes
};

/// How much is measured.
struct Effort {
    bool quick = false;
    int pictureExtent() const { return quick ? 96 : 512; }  // pixels an axis, at most
    int comparedExtent() const { return quick ? 96 : 128; } // of them that are compared
    int blocks() const { return quick ? 2 : seconds > 0 ? 3 : 5; }
    int rounds() const { return quick ? 2 : 4; } // of a block
    /// Then a block takes it once.
    double secondsPerSetting() const { return quick ? 0.4 : seconds > 0 ? 0.6 : 2; }
    /// For first pictures, errors and counts; what comes later is left out, and listed.
    double secondsForPictures() const { return seconds > 0 ? seconds : quick ? 40 : 1e9; }
    double seconds = 0; // of that, where told
    /// Where the calibration moved, at most, a block.
    int repeatedBlocks() const { return quick || seconds > 0 ? 0 : 2; }
    std::size_t provenRays() const { return quick ? 64 : 256; }
};

/// Times of a setting in one block.
struct BlockTimes {
    std::vector<double> wallMs;
    double gpuMs = 0; // least
};

struct Measured {
    Planned planned;
    ImageError error; // of the compared pixels
    Work work;
    std::string features;
    Integrator integrator = Integrator::midpoint; // that an automatic one came to
    std::size_t peakRamBytes = 0, peakGpuBytes = 0;
    std::uint64_t bytesDecoded = 0;
    /// Light that ending rays early may leave out, and whether it does not leave out more (and adds none),
    /// against the same setting with rays that go on.
    double bound = 0;
    bool boundOk = true;
    std::vector<BlockTimes> blocks;

    double leastMs() const; // over all blocks
    std::vector<double> leastOfBlocks() const;
};

/// What could not be measured, or should not have come out.
struct Failure {
    std::string scene, setting, what;
};

struct Sweep {
    NamedScene scene;
    glm::ivec2 imageSize{0};
    int pixelStride = 1;        // every so many pixels of every so many rows are compared
    std::string device, volume; // EngineMaker::about(); "512 x 512 x 134, int16"
    RayProof proof;
    double tableError = 0; // of the transfer function's table
    std::vector<Measured> measured;
    std::vector<Failure> failures;
    int blocksMoved = 0, blocksMeasured = 0; // blocks kept though the calibration moved by more than 2 %
    double loadBefore = 0, loadAfter = 0;

    const Measured* find(const Setting& setting) const;
    /// Errors below this are not told apart from the reference's own.
    double floor() const;
};

struct SweepOptions {
    EngineKind engine = EngineKind::automatic; // that draws the settings
    std::string device = "auto";
    std::size_t ramBytes = 0, gpuBytes = 0;
    Effort effort;
    std::vector<Integrator> integrators; // of plannedSettings()
    std::vector<Planned> settings;       // empty: plannedSettings()
};

/// Throws InputError where not even the scene as it is can be drawn within the budgets.
Sweep runSweep(const NamedScene& scene, const SweepOptions& options, const CommonOptions& common);

} // namespace tessera::accuracy
