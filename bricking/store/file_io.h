// bricking/store/file_io.h: the few file operations that a store needs, with errors that name the file.
// Reading follows no link below the store's folder and opens regular files only, so a store
// cannot point elsewhere.
#pragma once

#include "core/base/file_handle.h"

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
/// @return nothing when the file or a folder on the way is missing
/// Throws InputError naming the path for links, for what is not a regular file, and when it cannot be opened.
std::optional<FileHandle> openIn(const FileHandle& folder, std::string_view relative,
                                 const std::filesystem::path& shown);

std::uint64_t fileSize(const FileHandle& file, const std::string& shown);
/// Fills out from offset. Throws InputError naming the file when it ends too early or cannot be read.
void readAt(const FileHandle& file, std::uint64_t offset, std::span<std::byte> out, const std::string& shown);
/// The whole file as text; nothing when missing. Throws InputError when it is larger than limitBytes.
std::optional<std::string> readText(const FileHandle& folder, std::string_view relative,
                                    const std::filesystem::path& shown, std::uint64_t limitBytes);

/// Opens a file for writing, made if missing, kept if not. Throws Error naming it.
FileHandle openForWriting(const std::filesystem::path& path);
void writeAt(const FileHandle& file, std::uint64_t offset, std::span<const std::byte> bytes,
             const std::filesystem::path& shown);
/// Writes a whole file, closed and checked. Not durable until syncAll().
void writeFile(const std::filesystem::path& path, std::span<const std::byte> bytes);
void writeFile(const std::filesystem::path& path, std::string_view text);

/// Makes everything written so far to folder's file system durable, names included: one wait, where a store's
/// hundred files and folders would each cost a journal commit. Throws Error.
void syncAll(const std::filesystem::path& folder);
/// Makes the list of names in one folder durable: after a rename.
void syncFolder(const std::filesystem::path& folder);

} // namespace tessera
