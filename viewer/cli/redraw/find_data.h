// viewer/cli/redraw/find_data.h: finds a picture's data by their content: among named paths, in the picture's
// folder, and in the cache of imports.
#pragma once

#include "core/base/budget.h"
#include "core/scene/scene.h"
#include "viewer/cli/manifest/picture_data.h"
#include "viewer/cli/options/options.h"

#include <filesystem>
#include <string>
#include <vector>

namespace tessera {

struct FoundData {
    PictureData wanted;
    std::string contentHash; // of what was found
    std::string where;       // "--data", "beside the picture", "the cache of imports"
};

/// The named path of each datum; "": none is named. Stores by their content first, the rest in order for data
/// of their kind. Throws InputError naming a path for which there is no datum.
std::vector<std::string> assignData(const std::vector<PictureData>& wanted,
                                    const std::vector<std::string>& named, MemoryBudget& ram);

/// Sets all paths of the scene to the data that are found. Named paths are taken with another content, too.
/// Other places count only with the same content.
/// @param sources  what to choose among source files, of each volume
/// @param paths    of assignData()
/// Throws InputError naming the picture, and the content, for data that are nowhere.
std::vector<FoundData> findData(const std::filesystem::path& figure, const std::vector<PictureData>& wanted,
                                const std::vector<SourceChoice>& sources,
                                const std::vector<std::string>& paths, Scene& scene, MemoryBudget& ram,
                                const CommonOptions& common);

} // namespace tessera
