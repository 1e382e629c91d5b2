// bricking/store/work_folder.h: WorkFolder: the folder in which a store is made in parts, beside its target.
// It can outlive its process: a later one goes on with what is finished, and several can work in it at once.
//
//     .NAME.importing-KEY/store              what becomes the store; missing: it has its name already
//     .NAME.importing-KEY/part-0003          a finished part
//     .NAME.importing-KEY/.part-0003.claim   a process is making it (core/base/claims.h)
#pragma once

#include "core/base/claims.h"
#include "core/base/files.h"
#include "core/base/interrupt.h" // TemporaryPath

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace tessera {

class WorkFolder {
  public:
    struct Use {
        std::string key;     // 32 hex digits of all that the store depends on; "": not to be continued
        bool shared = false; // several processes may work in it
    };
    /// Opens the folder with the key, or makes it. Removes what dead processes left of other work for the
    /// target, and what recoverFolders() does. Throws InputError if the target's parent is missing or another
    /// process works in the folder and either does not share it; Error if it cannot be made.
    WorkFolder(const std::filesystem::path& target, const Use& use);
    /// If it was not published: keeps it if it has a finished part and discard() was not called, or if
    /// another process works in it; else removes it.
    ~WorkFolder();
    WorkFolder(const WorkFolder&) = delete;
    WorkFolder& operator=(const WorkFolder&) = delete;

    const std::filesystem::path& path() const { return path_; }
    std::filesystem::path store() const { return path_ / "store"; }
    std::filesystem::path part(int number) const { return path_ / nameOfPart(number); }
    static std::string nameOfPart(int number);
    const Claims& claims() const { return *claims_; }
    /// True if another process may go on with what is finished.
    bool outlives() const { return !use_.key.empty(); }
    /// True once another process has given the store its name.
    bool isFinished() const;

    /// Makes a part, of which this process has the claim: `make` writes it into a new folder, which then gets
    /// the part's name. Removes what dead processes left of theirs.
    void makePart(int number, const std::function<void(const std::filesystem::path&)>& make);
    /// What is finished is of no use.
    void discard() { isDiscarded_ = true; }
    /// Gives store() its name and removes the rest. Throws as publishFolder() does.
    /// @param durable  synchronise to disk first
    void publish(bool durable, bool replace);

    /// NAME of ".NAME.importing-KEY"; nullopt for any other.
    static std::optional<std::string> nameOf(const std::string& entry);
    /// Finished parts of such work for the target.
    static int partsOf(const std::filesystem::path& target, const std::string& key);
    /// Removes, in a folder, those without a finished part and without a process.
    static void sweepEmpty(const std::filesystem::path& folder);
    /// Removes those of a target without a process, but for the one with the key.
    static void sweepOf(const std::filesystem::path& target, const std::string& key);

  private:
    bool open();
    bool make(const std::filesystem::path& own);
    bool isAlone();
    std::filesystem::path target_, path_;
    Use use_;
    FileHandle held_; // the folder, locked if there are locks
    bool isLocked_ = false, isDiscarded_ = false, isPublished_ = false;
    std::optional<Claims> claims_;
    std::optional<TemporaryPath> unfinished_; // without a key
};

} // namespace tessera
