// viewer/cli/input/file_level.h: the level and the box of a source file that commands take as the volume.
#pragma once

#include "core/base/volume.h"
#include "viewer/cli/input/volume_input.h"
#include "viewer/cli/options/command.h"
#include "viewer/cli/options/options.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace tessera {

/// The level where none is asked for.
enum class UnsaidLevel {
    finest,
    fits // as auto, where the cache of imports has no room for the finest
};
/// The options with a level by number where they say auto: the finest whose decoded voxels fit into
/// cacheLimitBytes() (import_cache.h), else the coarsest; a note tells one that is not the finest. Options
/// without a level stay so where that is the finest. Throws InputError as opening the source does, and for
/// auto beside a box.
InputOptions withFileLevel(const std::filesystem::path& path, const InputOptions& options,
                           const CommonOptions& common, UnsaidLevel unsaid);

/// A level to show while the one that is meant is imported: the finest of at most so many bytes, decoded.
/// None: the import is in the cache, a level or a box is asked for, or no level is coarser and as small.
/// Throws as withFileLevel() does.
std::optional<int> levelToBeginWith(const std::filesystem::path& path, const InputOptions& options,
                                    std::uint64_t bytes);

/// "level 2 of its file, 256 x 256 x 64 voxels (the finest has 1024 x 1024 x 256), box 0,100,0,100,0,64".
std::string sayFilePart(const FilePart& part);

/// --file-level and --file-box, for addSelectionOptions().
void addFilePartOptions(Command& command, SourceChoice& choice);

} // namespace tessera
