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

/// Puts what the options say into the scene. Notes what a preset of another program says and no scene can.
/// Throws InputError naming the option for values that mean nothing, and for options that have no use beside
/// the scene or one another.
void applyArguments(const RenderArguments& arguments, Scene& scene, const CommonOptions& common);

/// `--no-check` is `--verify none`. Where neither is said, films are not checked.
/// Throws InputError naming the option for other words, and for both with different meanings.
Verify verifyOf(const RenderArguments& arguments);

/// Throws InputError naming --engine for what is no engine.
EngineKind engineOf(const RenderArguments& arguments);

} // namespace tessera
