// viewer/cli/manifest/manifest.h: the manifest of a picture: everything that it was made from, without
// identifiers. Paths are left out, because folders may have patients' names. The store is named by the hash
// of its content.
#pragma once

#include "bricking/store/store_reader.h"
#include "core/base/budget.h"
#include "core/scene/colour_legend.h"
#include "core/scene/measurement.h"
#include "core/scene/scene.h"
#include "render/backends/engine_maker.h"
#include "render/picture/render_scene.h"

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

namespace tessera {

/// The scene with its volumes named by their content, and other files by their number.
/// @param stores  of its volumes, in order
Scene withoutPaths(Scene scene, Stores stores);

/// The scene (with the camera's position), stores, device, engine, budgets and their use, resident bricks,
/// work counters, program version, "not for diagnosis". Include from .cpp files only.
nlohmann::json makeManifest(const Scene& scene, Stores stores, const RenderResult& result,
                            const MemoryBudget& ram, const MemoryBudget& gpu);
/// The manifest's "filePart" of a volume, beside what names the volume.
nlohmann::json filePartJson(const FilePart& part);
/// The manifest's "sources": what was chosen of each volume's source files, as scenes have it; empty where
/// nothing was.
nlohmann::json sourcesJson(std::span<const SourceChoice> sources);
/// All that pixels depend on besides budgets and cameras of a path, by readable names: for processes that
/// draw parts of one work. No paths: they may name a patient.
nlohmann::json recordOfPixels(const Scene& scene, Stores stores, const EngineMaker& engine);
/// The manifest's "damagedChunks": what coarser levels stood in for, of all volumes; null: nothing.
nlohmann::json damageJson(Stores stores);
/// The manifest's "scaleBar": the bar that was drawn into the picture.
nlohmann::json scaleBarJson(const ScaleBar& bar);
/// The manifest's "legend": the bars of colours that were, without their names.
nlohmann::json legendJson(std::span<const LegendBar> bars);
/// A report as a picture keeps it: ASCII only, for PNG's text is Latin-1, and what a device calls itself is
/// not ours to trust.
std::string manifestText(const nlohmann::json& report);

} // namespace tessera
