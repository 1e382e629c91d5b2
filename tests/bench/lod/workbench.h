// tests/bench/lod/workbench.h: tools that the experiments on volumes share: the volumes, and scenes on a
// device that can be drawn with any selection of levels.
#pragma once

#include "bricking/levels/level_chooser.h"
#include "core/base/work.h"
#include "core/image/image_metrics.h"
#include "core/scene/scene.h"
#include "render/backends/engine_maker.h"
#include "render/picture/render_scene.h"
#include "render/plan/planner.h"
#include "tests/bench/report/report.h"
#include "viewer/cli/options/options.h"

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace tessera::bench {

/// A volume under its public name, and the functions to show it with.
struct BenchVolume {
    std::string name, about;
    std::filesystem::path store;
    std::vector<std::string> presets;
    bool isScan = false;     // not generated
    bool seenBefore = false; // pictures of it were looked at while what is measured was made
};

/// Everything that experiments need; made once.
struct Workbench {
    EngineKind engine;  // as --engine says it: what draws, where a study does not say otherwise
    std::string device; // as --gl-device says it
    std::vector<BenchVolume> volumes;
    std::vector<std::string> leftOut; // names of volumes that are not at hand or were not asked for
    bool quick = false;
    std::size_t ramBytes = 0;
    const CommonOptions& common;
    std::string experiment;            // at hand
    mutable std::size_t partsDone = 0; // of it
    mutable std::size_t parts = 0;     // 0: not known

    /// An experiment begins. @param scenes  pairs of a volume and a preset that it goes through; 0: unknown
    void begin(const std::string& experiment, std::size_t scenes);
    /// The experiment itself knows how many there are.
    void expect(std::size_t scenes) const { parts = scenes; }
    /// One of them is done: says so, and how far the experiment is.
    void done(const std::string& what) const;
    /// Pairs of a volume and a preset that levels of detail are measured with.
    std::size_t scenes() const;
    int pixels() const { return quick ? 128 : 512; } // of pictures, an axis
    int fewerPixels() const { return pixels() / 2; } // of pictures that are only measured
};

/// What studies can draw with. Throws InputError for other names.
EngineKind studyEngine(const std::string& name);
const std::vector<std::string>& studyEngineNames();

/// The folder of scans: as told, or where the tests look for theirs, or none (empty). Throws InputError for
/// one that is not there.
std::filesystem::path scansFolder(const std::string& told);
/// Those that levels of detail are measured on, those that promised errors are, or all.
enum class VolumeSet { levels, calibration, all };
/// Names of all volumes that a workbench may have.
std::vector<std::string> volumeNames(VolumeSet set);
/// The generated volumes, written to scratchFolder, and those known scans that are in scansFolder (empty:
/// none); of those in `only`, unless it is empty. Scans are imported once, to the cache folder.
Workbench makeWorkbench(EngineKind engine, const std::string& device,
                        const std::filesystem::path& scansFolder, VolumeSet set,
                        const std::vector<std::string>& only, const std::filesystem::path& scratchFolder,
                        bool quick, std::size_t ramBytes, const CommonOptions& common);

/// The least budget of GPU memory that the program draws a scene in, found as a user would: by asking for too
/// little, and then for what it names. With that it may want more: tables that a byte had no room for.
std::size_t floorNamed(const std::function<void(MemoryBudget&)>& draw);

/// Cameras by name: "anterior" (perspective), "left" (parallel), "near" (perspective, oblique, half the
/// volume fills the picture), "inside" (in the volume, 110 degrees).
Camera cameraNamed(const std::string& name, const VolumeInfo& info, const glm::ivec2& size);

/// How a selection is drawn.
struct Setting {
    EdgeFunction edgeFunction = Quality{}.edgeFunction;
    Sampling sampling = Quality{}.sampling;
    bool skipping = true;
    bool counting = true; // false where time is taken
};

struct Drawn {
    Image image;
    Work work;
    std::optional<LightReport> light; // of voxels, where the scene has any
};

/// A volume, a function and a camera on an engine. One at a time: its GL context, if any, is the current one.
class SceneBench {
  public:
    /// Levels are always chosen for bench.pixels().
    /// @param pixels  of the pictures that are drawn, an axis; 0: bench.pixels()
    SceneBench(const Workbench& bench, const BenchVolume& volume, const std::string& preset,
               const std::string& camera, int pixels = 0, const Lighting& lighting = {});
    const FramePlan& prepared() const { return prepared_; }
    const VolumeInfo& info() const { return prepared_.info(); }
    const StoreReader& store() const { return store_; }
    /// Half of the budget, for what is computed besides pictures; pictures have the other half.
    MemoryBudget& analysisRam() { return analysisRam_; }
    /// "abdomen, bone, anterior"
    const std::string& name() const { return name_; }

    Drawn draw(Selection selection, const Setting& setting = {});
    /// What the camera sees of every brick past the others, counted over a selection's bricks.
    std::vector<float> countedVisibility(Selection selection);
    /// Against a truth of the same scene.
    static ImageDifference difference(const Drawn& drawn, const Drawn& truth) {
        return compare(drawn.image, truth.image);
    }

    /// Every brick that shows something at level 0: what culling alone leaves.
    const Selection& culled() const { return culled_; }
    /// 1 for each of these.
    const std::vector<std::uint8_t>& shows() const { return chooser_->shows(); }
    const LevelErrors& predicted() const { return chooser_->errors(); }
    const ViewWeights& weights() const { return chooser_->weights(); }
    /// Voxels of the volume to texels of the selection's pages.
    double reductionOf(const Selection& selection) const;
    /// The product's own choice for at least such a reduction: the first, by predicted visibility, and then
    /// by what was seen of that.
    Selection chosenAt(double reduction);
    /// What it takes for seen then.
    std::vector<float> seenAt(double reduction);
    Selection chosenAt(double reduction, Visibility visibility) const;
    /// What the bricks' rays predict.
    const std::vector<float>& visibility() const { return visibility_; }
    /// Pages that give at least such a reduction; at least 1.
    std::size_t pagesAt(double reduction) const;

  private:
    /// Its bricks, on an engine.
    void bring(Engine& engine, Selection selection, Work& work);

    const Workbench& bench_;
    EngineMaker engines_;
    std::string name_;
    MemoryBudget ram_, analysisRam_, gpu_;
    StoreReader store_;
    Planner prepared_;
    Selection culled_;
    std::optional<LevelChooser> chooser_;
    std::vector<float> visibility_;
};

} // namespace tessera::bench
