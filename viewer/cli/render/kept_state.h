// viewer/cli/render/kept_state.h: `--keep-state`: the file from which a later run goes on, and all of a scene
// that its samples depend on.
#pragma once

#include "render/pixels/kept_samples.h"
#include "viewer/cli/render/render_task.h"

#include <memory>

namespace tessera {

/// Throws InputError naming the option for films, scenes without paths of light, pixels of one sample or as
/// many as each needs, and a file that cannot be written or is the picture's.
void checkKeptState(const RenderArguments& arguments, const Scene& scene);

/// Null where nothing is kept. Throws as KeptSamples does.
std::unique_ptr<KeptSamples> keptStateOf(const RenderTask& task);

} // namespace tessera
