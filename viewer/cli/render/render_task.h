// viewer/cli/render/render_task.h: the task of `tessera render` after all early checks.
#pragma once

#include "bricking/store/store_reader.h"
#include "core/base/budget.h"
#include "core/scene/scene.h"
#include "render/picture/render_scene.h"
#include "viewer/annotations/figure.h"
#include "viewer/cli/input/phase_input.h"
#include "viewer/cli/options/options.h"
#include "viewer/cli/render/layers.h"
#include "viewer/cli/render/scene_from_arguments.h"

#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

struct RenderTask;
/// Takes a picture in place of its file, what its file would have over it, and its manifest. It may move the
/// result's images.
using TakePicture = std::function<void(const RenderTask& task, RenderResult& result, const Figure& figure,
                                       const nlohmann::json& manifest)>;

/// One picture, a film, or an unfolded wall. All references outlive it.
struct RenderTask {
    const RenderArguments& arguments;
    const CommonOptions& common;
    Scene scene;              // with the options applied; for films and walls without the path's cameras
    const StoreReader& store; // of the first volume
    Stores stores;
    MemoryBudget &ram, &gpu;
    RenderOptions options;
    LayerChoice layers = {};                // of one picture
    std::string request = {};               // requestOf() (asked_options.h)
    std::vector<SourceChoice> sources = {}; // of each volume, where it was source files
    TakePicture take = {};                  // of one picture; none: its file is written
    std::optional<Strips> strips = {};      // of a panel; none: those that its annotations need
    /// Of a film over phases: their stores, of which `store` is the first; and what opens one.
    const PhaseStores* phases = nullptr;
    std::function<std::unique_ptr<StoreReader>(const std::filesystem::path&)> open = {};
};

} // namespace tessera
