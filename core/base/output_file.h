// core/base/output_file.h: writes every result that is a single file (picture, page, table, scene). The file
// is written under a temporary name beside the target, with every step checked, and renamed when it is
// complete.
#pragma once

#include "core/base/files.h"
#include "core/base/interrupt.h" // TemporaryPath

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace tessera {

/// The path of a result after following links, also a link to a missing file. Throws InputError naming path
/// for circular links.
std::filesystem::path outputTarget(const std::filesystem::path& path);

/// What becomes of a file that has the name already.
enum class Existing { isReplaced, isKept };

/// Throws InputError naming path when no file can be written there: a folder, a device, a pipe or a socket
/// has the name. Likewise where the file is read-only, or its folder is missing or may not be written in, and
/// for an existing file that is kept.
void checkOutputFile(const std::filesystem::path& path, Existing existing = Existing::isReplaced);

/// Renames a file, unless something has the new name.
/// @param inOneStep  false: as on a file system or a kernel that cannot rename so; a hard link takes its
/// place
/// @return false if something has the name; `from` then stays. Throws Error naming `to` for any other
/// failure.
bool renameToNewFile(const std::filesystem::path& from, const std::filesystem::path& to,
                     bool inOneStep = true);

/// The NAME of an unfinished file's name, ".NAME.tessera-PID-N"; nullopt for any other.
std::optional<std::string> nameOfUnfinishedFile(std::string_view entry);

/// An unfinished file. The earlier file stays until finish(), and for good if that is never called.
class OutputFile {
  public:
    /// Makes ".NAME.tessera-PID-N" beside the file and removes those of dead processes. Throws InputError as
    /// checkOutputFile() does, Error when it cannot be made.
    explicit OutputFile(const std::filesystem::path& path, Existing existing = Existing::isReplaced);
    /// Removes the unfinished file.
    ~OutputFile();
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;

    /// Path of the unfinished file, for programs that write by name; they must write into it, not replace it.
    const std::filesystem::path& path() const { return path_; }
    /// Throws Error naming the target.
    void writeAt(std::uint64_t offset, std::span<const std::byte> bytes);
    /// Synchronises to disk, closes and renames; the old file's permissions stay. Throws Error naming the
    /// target, which is then unchanged; InputError where a file that is kept has appeared meanwhile.
    void finish();

  private:
    std::filesystem::path shown_, target_, path_;
    Existing existing_;
    FileHandle file_;
    std::optional<TemporaryPath> unfinished_;
    bool renamed_ = false;
};

/// Writes a whole file. Throws as OutputFile does.
void writeOutputFile(const std::filesystem::path& path, std::string_view text);

/// Flushes standard output. Throws Error if that fails: a full disk, a closed descriptor.
void finishStandardOutput();

} // namespace tessera
