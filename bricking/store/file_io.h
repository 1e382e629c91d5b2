// bricking/store/file_io.h: the few file operations that a store needs, with errors that name the file.
// Reading follows no link below the store's folder and opens regular files only, so a store
// cannot point elsewhere.
#pragma once

#include "core/base/files.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace tessera {

/// Opens a folder for openIn(). Throws InputError naming it.
FileHandle openFolder(const std::filesystem::path& path);

/// Opens a regular file below folder for reading.
/// @param relative  names joined by '/', none of them "", "." or ".."
/// @param shown  the folder's path, for messages
/// @return nullopt if the file or a folder of its path is missing
/// Throws InputError naming the path for links, for anything but a regular file, and if it cannot be opened.
std::optional<FileHandle> openIn(const FileHandle& folder, std::string_view relative,
                                 const std::filesystem::path& shown);

std::uint64_t fileSize(const FileHandle& file, const std::string& shown);
/// Fills out from offset. Throws InputError naming the file if it ends too early or cannot be read.
void readAt(const FileHandle& file, std::uint64_t offset, std::span<std::byte> out, const std::string& shown);
/// The whole file as text; nullopt if missing. Throws InputError if it is larger than limitBytes.
std::optional<std::string> readText(const FileHandle& folder, std::string_view relative,
                                    const std::filesystem::path& shown, std::uint64_t limitBytes);

/// Opens a file for writing; creates it if it is missing. Throws Error naming it.
FileHandle openForWriting(const std::filesystem::path& path);
void writeAt(const FileHandle& file, std::uint64_t offset, std::span<const std::byte> bytes,
             const std::filesystem::path& shown);
/// Writes a whole file, closed and checked. Not durable until syncAll().
void writeFile(const std::filesystem::path& path, std::span<const std::byte> bytes);
void writeFile(const std::filesystem::path& path, std::string_view text);

/// Makes everything written so far to folder's file system durable, including names: one wait instead of a
/// journal commit for each of a store's hundred files and folders. Throws Error.
void syncAll(const std::filesystem::path& folder);
/// Makes the names in one folder durable, after a rename.
void syncFolder(const std::filesystem::path& folder);

} // namespace tessera
