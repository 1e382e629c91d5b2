// viewer/cli/render/body_crop.h: `--crop body`: the box of the patient, added to the scene like any other
// box.
#pragma once

#include "bricking/store/store_reader.h"
#include "core/base/budget.h"
#include "core/scene/scene.h"
#include "viewer/cli/options/options.h"
#include "viewer/cli/render/render_arguments.h"

namespace tessera {

/// Adds the box of bricking/analysis/body/body_box.h to the scene's cuts and notes it. A camera by side is
/// fitted to what is shown within the cuts, unless --fit says otherwise. Throws InputError naming --crop for
/// values that are not in HU, and as findBody() does.
void cropToBody(const RenderArguments& arguments, const StoreReader& store, Scene& scene, MemoryBudget& ram,
                const CommonOptions& common);

} // namespace tessera
