// core/base/claims.h: claims of pieces of work that several processes share through a folder. A claim is a
// lock file, ".NAME.claim". It ends with its process, however that ends, and another process takes the piece.
// Lock files only save work: what is made must not depend on the process, and gets its name when complete.
#pragma once

#include "core/base/files.h"

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace tessera {

/// The kind of lock files. Kernel locks, which end with the process; or files whose time the owner renews, if
/// other machines may share the folder and kernel locks prove nothing.
enum class ClaimKind { lock, lease };

/// While it lives, no other process holds the claim of that name.
class Claim {
  public:
    ~Claim();
    Claim(const Claim&) = delete;
    Claim& operator=(const Claim&) = delete;
    /// False if another process took a lease over, because this one was stopped for too long.
    bool isHeld() const;

  private:
    friend class Claims;
    struct Renewal;
    Claim(std::filesystem::path path, FileHandle file, double renewSeconds);
    std::filesystem::path path_;
    FileHandle file_; // of kind lock: has the lock
    std::unique_ptr<Renewal> renewal_;
};

class Claims {
  public:
    /// Of the kind that proves an owner's end in the folder.
    explicit Claims(std::filesystem::path folder);
    /// @param leaseSeconds  without renewal, after which a lease is taken over; 0: a minute
    Claims(std::filesystem::path folder, ClaimKind kind, double leaseSeconds = 0);

    ClaimKind kind() const { return kind_; }
    /// Null if another process has it, or the lock file cannot be made.
    std::unique_ptr<Claim> claim(const std::string& name) const;
    /// True if its lock file is there.
    bool isTaken(const std::string& name) const;
    /// NAME of ".NAME.claim"; nullopt for any other.
    static std::optional<std::string> nameOf(std::string_view entry);

  private:
    std::filesystem::path pathOf(const std::string& name) const;
    FileHandle takeLease(const std::filesystem::path& path) const;
    std::filesystem::path folder_;
    ClaimKind kind_;
    double leaseSeconds_;
};

} // namespace tessera
