// render/picture/render_scene.h: renders a scene to one converged picture, by any engine.
#pragma once

#include "bricking/store/store_reader.h"
#include "core/base/budget.h"
#include "core/scene/scene.h"
#include "render/engine.h"
#include "render/renderer.h"

#include <memory>
#include <span>
#include <string>
#include <vector>

namespace tessera {

/// An engine by its kind, and its resources. If it needs a GL context, its own is current on the calling
/// thread. All calls then come from that thread, the release by the last owner too.
std::shared_ptr<Engine> makeEngine(const RenderOptions& options, MemoryBudget& ram, MemoryBudget& gpu);
/// One that can draw a scene. Throws InputError if the requested one cannot, and where withLabelOptics()
/// does.
/// @param stores  of the scene's volumes, in order
std::shared_ptr<Engine> makeEngine(const Scene& scene, Stores stores, const RenderOptions& options,
                                   MemoryBudget& ram, MemoryBudget& gpu);

/// The options with the engine that draws a scene: where none is named and the automatic one cannot, another.
/// Throws as makeEngine() does.
RenderOptions optionsFor(const Scene& scene, Stores stores, const RenderOptions& options);

/// Why an engine cannot draw a scene as it is drawn (asDrawn()); empty: it can.
std::string whyNotDrawn(const Scene& scene, EngineKind kind, const RenderOptions& options);

/// RAM that an engine and its caller take for a pixel; the caller charges it for as long as
/// it keeps pictures.
std::size_t pictureBytesPerPixel(EngineKind engine);
/// The same of pictures whose pixels have so many samples.
std::size_t pictureBytesPerPixel(EngineKind engine, const PixelSampling& pixels);

/// True if a scene has rays that leave places in the volume and show what they meet: paths of light, or
/// reflections of isosurfaces.
bool followsWays(const Scene& scene);

/// Renders one converged picture. Everything large is charged to ram and gpu. Throws InputError for budgets
/// below the scene's floor, Error for failures outside.
/// @param stores  of the scene's volumes, in order
RenderResult renderScene(const Scene& scene, Stores stores, MemoryBudget& ram, MemoryBudget& gpu,
                         const RenderOptions& options);
/// Of a scene of one volume.
RenderResult renderScene(const Scene& scene, const StoreReader& store, MemoryBudget& ram, MemoryBudget& gpu,
                         const RenderOptions& options);

/// As a first picture is drawn: a sample of the coarse level a step, not two, nothing tried or estimated, one
/// ray a pixel and no reflections.
Scene firstScene(const Scene& scene);

/// The contents of the picture and the parts left out, a line each: features, level, culled bricks, empty
/// space.
std::vector<std::string> explain(const RenderResult& result, const Scene& scene);

} // namespace tessera
