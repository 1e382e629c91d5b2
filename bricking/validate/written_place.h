// bricking/validate/written_place.h: whether a repair may write at a place in a store.
#pragma once

#include <filesystem>
#include <string>

namespace tessera {

/// Repairs follow no link below the store's folder, and replace nothing but files and folders.
/// @param relative  names joined by '/'
/// @return "", or why nothing is written there: "1/c is a symbolic link"
std::string whyNotWritten(const std::filesystem::path& store, const std::filesystem::path& relative);

} // namespace tessera
