// viewer/cli/render/scene_from_arguments.h: the scene to draw: the named one, changed by the options.
// Options win over the scene.
#pragma once

#include "core/scene/scene.h"
#include "render/picture/render_scene.h" // Verify, EngineKind
#include "viewer/cli/options/options.h"
#include "viewer/cli/render/render_arguments.h"

#include <string>
#include <vector>

namespace tessera {

/// Applies the options to the scene. Notes settings of a foreign preset that no scene has. Throws InputError
/// naming the option for invalid values, and for options without effect beside the scene or one another.
void applyArguments(const RenderArguments& arguments, Scene& scene, const CommonOptions& common);

/// `--no-check` is `--verify none`. Without either, films are not checked. Throws InputError naming the
/// option for other words, and for both with different meanings.
Verify verifyOf(const RenderArguments& arguments);

/// Throws InputError naming --engine for an unknown engine.
EngineKind engineOf(const RenderArguments& arguments);

} // namespace tessera
