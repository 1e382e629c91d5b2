// viewer/session/open_volume.h: an open volume: its store, its shares of the budgets, the renderer of its
// pictures, and the threads beside them. It belongs to one thread.
#pragma once

#include "bricking/store/store_reader.h"
#include "core/base/budget.h"
#include "core/base/progress.h"
#include "render/interactive/interactive_renderer.h"
#include "viewer/session/line_finder.h"
#include "viewer/session/still.h"
#include "viewer/session/view_session.h"

#include <filesystem>
#include <memory>
#include <optional>

namespace tessera {

/// In the order in which it must be let go, backwards.
struct OpenVolume {
    /// Opens what is named, importing what is not a store; there is no renderer yet. Where pictures that
    /// follow one another would not fit beside stills, stills are left out.
    /// @param pictureSize  pixels, in place of the scene's
    /// @param input  which of several volumes
    /// Throws InputError naming the path or a budget; Cancelled.
    static std::unique_ptr<OpenVolume> open(const ViewSessionOptions& options,
                                            const std::filesystem::path& path, const InputOptions& input,
                                            const glm::ivec2& pictureSize,
                                            const std::shared_ptr<Progress>& progress);

    /// A renderer of a scene, in the place of the one before, which goes first. Spells out its camera.
    /// Throws InputError naming a budget that is too small: then there is none.
    void makeRenderer(const Scene& scene);
    /// What others may know of it; needs a renderer. Spells out the scene's function.
    std::shared_ptr<VolumeSeen> describe();
    /// Memory, bricks and chunks as they are; the rest of it stays unsaid. Needs a renderer.
    ViewingState usage() const;

    const ViewSessionOptions& options; // outlive this
    std::filesystem::path path;        // as it was named
    const bool stills;                 // whether they have half of both budgets
    MemoryBudget ram, gpu, sliceRam, stillRam, stillGpu;
    std::unique_ptr<StoreReader> store;
    Charge pictures;
    std::shared_ptr<Engine> engine;
    std::unique_ptr<InteractiveRenderer> renderer; // null: what was asked for could not be drawn
    Scene scene;                                   // that the renderer draws
    std::optional<FittedView> fitted;              // what the scene's camera was as it was opened
    std::unique_ptr<Still> still;                  // while one is drawn
    std::unique_ptr<LineFinder> line;              // while one is looked for

  private:
    OpenVolume(const ViewSessionOptions& sessionOptions, const std::filesystem::path& named, bool withStills);
};

} // namespace tessera
