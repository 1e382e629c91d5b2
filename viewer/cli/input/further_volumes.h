// viewer/cli/input/further_volumes.h: the volumes of a scene besides its first.
#pragma once

#include "bricking/store/store_reader.h"
#include "core/base/budget.h"
#include "core/scene/scene.h"
#include "viewer/cli/options/options.h"

#include <filesystem>
#include <glm/mat4x4.hpp>
#include <memory>
#include <string>
#include <vector>

namespace tessera {

/// What becomes of chunks that cannot be read.
enum class Damage { isRefused, isDrawnCoarser };

/// A store for pictures. A refusal of a chunk names the option that allows it.
std::unique_ptr<StoreReader> openForPictures(const std::filesystem::path& store, MemoryBudget& ram,
                                             const glm::dmat4& moved, Damage damage);

/// Opens their stores, imported where they are none, and names what their scene leaves open: functions and
/// imports of labels. Throws InputError as storeFor() and importLabelsFor() do.
std::vector<std::unique_ptr<StoreReader>> openFurtherVolumes(Scene& scene, MemoryBudget& ram,
                                                             const CommonOptions& common, Damage damage);

/// A line for each such chunk that is named: "volume 1: level 0 chunk (1,0,2) is damaged and drawn from level
/// 1".
std::vector<std::string> damageLines(Stores stores);

/// Says that coarser levels stood in for damaged chunks of stores, a line a store, and what the first one is;
/// even with --quiet. Nothing where there are none.
/// @param scene  of these volumes; the paths are shown
void sayDamage(const Scene& scene, Stores stores, const CommonOptions& common);

/// Names those whose boxes do not meet the first's; "" if all do.
std::string apartText(Stores stores);

/// Names those whose frame of reference is another than the first's, where no transform moves either; "" if
/// there is none.
std::string otherFramesText(const Scene& scene, Stores stores);

/// The frames of reference whose places are those of the picture: the first volume's, and those of others
/// that no transform moves. Empty where the first's is unknown, or it is moved.
std::vector<std::string> framesOfPicture(const Scene& scene, Stores stores);

/// Their stores after the first's.
std::vector<const StoreReader*> storesOf(const StoreReader& first,
                                         const std::vector<std::unique_ptr<StoreReader>>& further);

} // namespace tessera
