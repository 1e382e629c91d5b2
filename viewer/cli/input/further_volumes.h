// viewer/cli/input/further_volumes.h: the volumes of a scene besides its first.
#pragma once

#include "bricking/store/store_reader.h"
#include "core/base/budget.h"
#include "core/scene/scene.h"
#include "viewer/cli/options/options.h"

#include <memory>
#include <string>
#include <vector>

namespace tessera {

/// Opens their stores, imported where they are none, and names what their scene leaves open: functions and
/// imports of labels. Throws InputError as storeFor() and importLabelsFor() do.
std::vector<std::unique_ptr<StoreReader>> openFurtherVolumes(Scene& scene, MemoryBudget& ram,
                                                             const CommonOptions& common);

/// Names those whose boxes do not meet the first's; "" if all do.
std::string apartText(Stores stores);

/// Their stores after the first's.
std::vector<const StoreReader*> storesOf(const StoreReader& first,
                                         const std::vector<std::unique_ptr<StoreReader>>& further);

} // namespace tessera
