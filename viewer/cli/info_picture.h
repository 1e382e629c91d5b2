// viewer/cli/info_picture.h: prints the manifest of a picture, for `tessera info`.
#pragma once

#include <filesystem>
#include <string>

namespace tessera {

/// Prints a line of `info`; control characters in value are escaped.
void printLine(const char* key, const std::string& value);
/// True if it is a file with the name of a picture.
bool isPictureName(const std::filesystem::path& path);

/// Prints the manifest of a picture: its settings and its error; or all of it, as JSON. Throws InputError
/// naming path for a file that is no picture, or has no manifest.
void infoPicture(const std::filesystem::path& path, bool asJson);

} // namespace tessera
