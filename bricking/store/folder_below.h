// bricking/store/folder_below.h: openFolderIn(): folders below an open one, as openIn() (store_files.h) opens
// files.
#pragma once

#include "bricking/store/store_files.h"

#include <filesystem>
#include <optional>
#include <string_view>

namespace tessera {

/// Opens a folder below another one, name by name: no link on the way is followed, whoever puts one there.
/// @param relative, shown  as of openIn()
/// @return nullopt if a folder of the path is missing; behind an address it is not looked for
/// Throws InputError naming the path for links, for anything but a folder, and if it cannot be opened.
std::optional<StoreFolder> openFolderIn(const StoreFolder& folder, std::string_view relative,
                                        const std::filesystem::path& shown);

} // namespace tessera
