// viewer/claims/claimed_folder.h: the parts of one work, such as frames of a film or tiles of a picture, in a
// folder that several processes may fill together. A part exists once it has its name. The process that makes
// it holds a claim beside it, ".frame-000012.png.claim" (core/base/claims.h). Parts do not depend on the
// process, and get their names when complete.
#pragma once

#include "core/base/claims.h"
#include "core/base/files.h"

#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace tessera {

/// What a folder holds, by its files' names and in words.
struct ClaimedWork {
    std::string record;                   // the file that says of what the parts are: "film.json"
    std::string begin, end;               // of a part's name, around its number: "frame-", ".png"
    std::string work, parts;              // "film", "frames"
    std::vector<std::string> others = {}; // further names that are claimed or agreed upon
    std::string hint = "choose another folder, or remove this one"; // where it is of another work
    std::string marks =
        {}; // begin of the names of further files, which are numbered from 0; "": there are none
};

class ClaimedFolder {
  public:
    /// Opens the folder, or makes it.
    /// @param record  everything that parts depend on, by readable names: kept in the folder
    /// Throws InputError naming the folder if it has parts of another work, or parts without a record, or is
    /// no folder; Error if it cannot be made.
    ClaimedFolder(const std::filesystem::path& folder, ClaimedWork work, const nlohmann::json& record);
    /// For tests.
    ClaimedFolder(const std::filesystem::path& folder, ClaimedWork work, const nlohmann::json& record,
                  ClaimKind kind, double leaseSeconds);
    ~ClaimedFolder();
    ClaimedFolder(const ClaimedFolder&) = delete;
    ClaimedFolder& operator=(const ClaimedFolder&) = delete;

    /// "frame-000012.png"
    static std::string nameOf(const ClaimedWork& work, std::size_t part);
    std::string nameOf(std::size_t part) const { return nameOf(work_, part); }
    /// "finished-0"
    static std::string nameOfMark(const ClaimedWork& work, std::size_t number);
    std::filesystem::path pathOf(const std::string& name) const { return folder_ / name; }
    bool has(const std::string& name) const;
    /// False if someone removed the folder or its record.
    bool isThere() const { return has(work_.record); }

    /// Null if the part exists, or another process is making it.
    std::unique_ptr<Claim> claim(const std::string& name);
    /// A further record, which is known later: kept in the folder, where it must be the same for all.
    /// @param name  one of ClaimedWork::others
    /// @param hint  how those who differ become alike
    /// Throws as the constructor does.
    void agree(const std::string& name, const nlohmann::json& record, const std::string& hint);
    /// False where other machines may have the folder open, which nothing tells.
    bool tellsWhoIsThere() const { return claims_.kind() == ClaimKind::lock; }
    /// Removes all files of the work, and the folder if it is then empty, unless another process has it open.
    /// Nothing but this and the destructor may follow. Returns true where that is done.
    bool removeIfAlone();

  private:
    bool isPart(const std::string& name) const;
    bool isFurther(const std::string& name) const;
    bool isClaim(const std::string& name) const;
    bool isOwn(const std::string& name) const;
    void adopt(const nlohmann::json& record);
    void publish(const std::string& name, const nlohmann::json& record) const;
    void compare(const std::string& name, const nlohmann::json& record, const std::string& hint) const;
    void removeUselessClaims();
    std::filesystem::path folder_;
    ClaimedWork work_;
    Claims claims_;
    FileHandle open_; // the record, with a shared lock
};

} // namespace tessera
