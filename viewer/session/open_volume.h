// viewer/session/open_volume.h: an open volume: its store, its shares of the budgets, the renderer of its
// pictures, and the threads beside them. It belongs to one thread.
#pragma once

#include "bricking/store/store_reader.h"
#include "core/base/budget.h"
#include "core/base/progress.h"
#include "render/interactive/interactive_renderer.h"
#include "viewer/cli/input/phase_input.h"
#include "viewer/session/background_work.h"
#include "viewer/session/finer_import.h"
#include "viewer/session/view_session.h"
#include "viewer/session/volume_labels.h"

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

/// Members are destroyed in reverse order.
struct OpenVolume {
    /// Opens a path, importing unless it is a store; without a renderer yet. If interactive pictures would
    /// not fit beside stills, stills are left out.
    /// @param pictureSize  pixels, in place of the scene's
    /// @param input  which of several volumes
    /// @param level  of the file, for now: the scene does not say it
    /// Throws InputError naming the path or a budget; Cancelled.
    static std::unique_ptr<OpenVolume> open(const ViewSessionOptions& options,
                                            const std::filesystem::path& path, const InputOptions& input,
                                            const glm::ivec2& pictureSize,
                                            const std::shared_ptr<Progress>& progress,
                                            const std::optional<int>& level = {});
    /// The look of another level or phase of the same volume in place of the scene's: all of the scene but
    /// the choice of the source, labels imported anew. Throws InputError naming labels that cannot be.
    void takeLook(const OpenVolume& other, const std::shared_ptr<Progress>& progress);

    /// Makes a renderer of a scene, after destroying the one before. Resolves its camera. Where no
    /// interactive picture has all its volumes, the renderer is of the first alone. Throws InputError naming
    /// a budget that is too small: then there is none.
    /// @param detail  coarse: soon, for a first picture (InteractiveOptions::coarse), where that pays
    void makeRenderer(const Scene& scene, PlanDetail detail = PlanDetail::whole);
    /// Public data of the volume; needs a renderer. Resolves the scene's functions.
    std::shared_ptr<VolumeSeen> describe();
    struct Labelled {
        Scene scene;
        std::unique_ptr<VolumeLabels> labels;
    };
    /// The scene of the renderer with labels from a file in place of its own, imported. Throws InputError
    /// naming what cannot be imported; Cancelled.
    Labelled labelled(const std::filesystem::path& file, const std::shared_ptr<Progress>& progress);
    /// The values of the labels of a voxel, level 0. Needs a renderer. Throws InputError naming what cannot
    /// be read.
    std::vector<std::uint32_t> labelsAt(const glm::dvec3& voxel);
    /// Current memory, bricks and chunks; other members stay default. Needs a renderer.
    ViewingState usage() const;

    const ViewSessionOptions& options; // outlive this
    std::filesystem::path path;        // path as given
    const bool stills;                 // stills have half of both budgets
    MemoryBudget ram, gpu, sliceRam, stillRam, stillGpu;
    std::unique_ptr<StoreReader> store;
    std::vector<std::unique_ptr<StoreReader>> further; // of the scene's other volumes
    std::string firstAlone; // why interactive pictures show the first volume alone; empty: they show all
    std::unique_ptr<VolumeLabels> labels; // null: the scene has none
    std::filesystem::path eitherFile;     // as VolumeSeen has it
    PhaseList phases;                     // of the scene's first volume
    Charge pictures, meshes, environment;
    std::shared_ptr<MemoryBudget> savingRam; // of `pictures`: for one that is saved as it is shown
    std::shared_ptr<Engine> engine;
    std::unique_ptr<InteractiveRenderer> renderer; // null: the scene could not be drawn
    Scene scene;                                   // scene of the renderer
    std::optional<FittedView> fitted;              // the scene's camera when it was opened
    std::unique_ptr<Still> still;                  // while one is drawn
    std::unique_ptr<LineFinder> line;              // while one is searched
    std::unique_ptr<FinerImport> finer;            // while the level that is meant is imported

  private:
    std::unique_ptr<VolumeLabels> openLabels(Labels& named, const CommonOptions& common);
    OpenVolume(const ViewSessionOptions& sessionOptions, const std::filesystem::path& named, bool withStills);
};

} // namespace tessera
