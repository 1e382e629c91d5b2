// viewer/cli/render/asked_options.h: the manifest's "options": all that a picture depends on besides its
// scene, its data and its budgets, so that it can be drawn again; and the scene before anything was found.
#pragma once

#include "core/scene/scene.h"
#include "viewer/cli/render/render_task.h"

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace tessera {

/// A number for a scene as it was asked for, before cameras are fitted and functions are named. Equal for
/// equal scenes, wherever their data lie: 16 digits.
std::string requestOf(const Scene& scene);

/// "engine", "glDevice", "verify", "allowDamaged", "tile", "layers", "keepState", "processors", "sources"
/// (what was chosen among source files, of each volume) and, where it is told, "request". Include from .cpp
/// files only.
nlohmann::json optionsJson(const RenderTask& task);
/// The same before a picture is drawn, without "sources".
nlohmann::json optionsJson(const RenderArguments& arguments, const LayerChoice& layers,
                           const std::string& request);

} // namespace tessera
