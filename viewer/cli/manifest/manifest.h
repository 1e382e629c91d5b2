// viewer/cli/manifest/manifest.h: the manifest of a picture: everything that it was made from, without
// identifiers. Paths are left out, because folders may have patients' names. The store is named by the hash
// of its content.
#pragma once

#include "bricking/store/store_reader.h"
#include "core/base/budget.h"
#include "core/scene/measurement.h"
#include "core/scene/scene.h"
#include "render/picture/render_scene.h"

#include <nlohmann/json_fwd.hpp>

namespace tessera {

/// The scene (with the camera's position), store, device, engine, budgets and their use, resident bricks,
/// work counters, program version, "not for diagnosis". Include from .cpp files only.
nlohmann::json makeManifest(const Scene& scene, const StoreReader& store, const RenderResult& result,
                            const MemoryBudget& ram, const MemoryBudget& gpu);
/// The manifest's "scaleBar": the bar that was drawn into the picture.
nlohmann::json scaleBarJson(const ScaleBar& bar);

} // namespace tessera
