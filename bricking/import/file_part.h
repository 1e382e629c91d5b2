// bricking/import/file_part.h: a part of a file as the volume: one of the levels of a file that has several,
// a box of it, or both.
#pragma once

#include "bricking/import/source/slab_source.h"

#include <functional>
#include <memory>
#include <string>

namespace tessera {

/// The options without a level and a box.
SourceOptions finestOf(const SourceOptions& options);

/// Opens the level and the box that options ask for, axes as the file has them. Throws InputError naming
/// `where` for a level that the file does not have, and for a box beyond the level.
/// @param open  opens the file at a level
std::unique_ptr<SlabSource>
openFilePart(const std::function<std::unique_ptr<SlabSource>(const SourceOptions&)>& open,
             const SourceOptions& options, const std::string& where);

} // namespace tessera
