// viewer/cli/input/label_input.h: the labels beside a scene's volume, imported to its lattice.
#pragma once

#include "core/base/budget.h"
#include "core/base/volume.h"
#include "core/scene/labels.h"
#include "viewer/cli/options/options.h"

namespace tessera {

/// Sets `labels.store`: the import of the labels for a volume, in the cache of imports, made now if there is
/// none. Nothing where there are no labels. Throws InputError as importLabels() does.
void importLabelsFor(const VolumeInfo& scan, Labels& labels, MemoryBudget& ram, const CommonOptions& common);

} // namespace tessera
