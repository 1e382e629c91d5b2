// bricking/store/temporary_folder.h: a folder that gets its final name only when it is whole.
#pragma once

#include "core/interrupt.h" // TemporaryPath

#include <filesystem>
#include <optional>

namespace tessera {

class TemporaryFolder {
  public:
    /// Makes ".NAME.importing-PID-N" beside target, on the same file system, so that a rename is atomic.
    /// Throws InputError when the target's parent is missing, Error when the folder cannot be made.
    explicit TemporaryFolder(const std::filesystem::path& target);
    /// Removes the folder and all that is in it, unless it was renamed.
    ~TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    const std::filesystem::path& path() const { return path_; }
    /// Makes the folder tree durable, unless told not to wait for that, and renames it to the target. An
    /// existing target is exchanged with it in one step where the file system can, and removed afterwards.
    /// Throws Error; the target is then as it was.
    void commit(bool durable = true);

  private:
    std::filesystem::path target_, path_;
    std::optional<TemporaryPath> unfinished_;
    bool committed_ = false;
};

} // namespace tessera
