// viewer/cli/input/source_facts.h: what tells that the files of an import are the same as before, without
// reading them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

namespace tessera {

constexpr std::size_t kHashDigits = 16;
/// FNV-1a, 64 bits, as hexadecimal digits. It need not resist attacks, since users own their folders.
/// Different start values give independent hashes.
std::string hexHash(const std::string& text, std::uint64_t start = 0xCBF29CE484222325u);
/// A second one of the same text.
std::string hexCheck(const std::string& text);

/// One line for every regular file below path, or for path itself: its relative name, inode, size, times of
/// writing and of change. Unfinished folders of imports do not count.
/// @param leftOut  "FOLDER/" below path whose files do not count either; "" none
std::string factsOf(const std::filesystem::path& path, const std::string& leftOut = {});
/// Of source files, and of all others that hold their voxels.
/// @param path  as the importer gets it: names in a header are relative to its folder, not to a link's
/// target
std::string factsOfSource(const std::filesystem::path& path);

/// ImportOptions::key of source files.
/// @param options  all that affects the result besides the files
std::string importKey(const std::filesystem::path& given, const std::string& options);

} // namespace tessera
