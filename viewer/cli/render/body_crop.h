// viewer/cli/render/body_crop.h: `--crop body`: the box of the patient, put into the scene like any
// other box.
#pragma once

#include "bricking/store/store_reader.h"
#include "core/base/budget.h"
#include "core/scene/scene.h"
#include "viewer/cli/options/options.h"
#include "viewer/cli/render/render_arguments.h"

namespace tessera {

/// Adds the box that is found (bricking/analysis/body/body_box.h) to the scene's cuts and notes it. A camera
/// by side holds what is shown within the cuts, unless --fit names something else. Throws InputError naming
/// --crop for values that are not in HU, and what findBody() throws.
void cropToBody(const RenderArguments& arguments, const StoreReader& store, Scene& scene, MemoryBudget& ram,
                const CommonOptions& common);

} // namespace tessera
