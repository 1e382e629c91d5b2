// viewer/cli/info_picture.h: prints the manifest of a picture, for `tessera info`.
#pragma once

#include <filesystem>
#include <string>

namespace tessera {

/// A line of what `info` prints; controls in value are escaped.
void printLine(const char* key, const std::string& value);
/// Whether it is a file with a name that pictures have.
bool isPictureName(const std::filesystem::path& path);

/// Prints what the manifest in a picture says: how it was made and how wrong it is; or all of it, as JSON.
/// Throws InputError naming path for what is no picture, or has no manifest.
void infoPicture(const std::filesystem::path& path, bool asJson);

} // namespace tessera
