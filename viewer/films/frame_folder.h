// viewer/films/frame_folder.h: the frames of one film in a folder that several processes may fill together. A
// frame is there once it has its name. Its process holds a lock file (a claim) beside it,
// ".frame-000012.png.claim". A claim ends with its process, however that ends, and another process takes the
// frame. Claims only save work: frames are equal whoever draws them, and get their names whole.
#pragma once

#include "core/base/file_handle.h"
#include "core/base/ownership.h"

#include <cstddef>
#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace tessera {

/// The kind of claims. Locks, which the kernel drops when a process ends; or files whose time their owner
/// renews, where other machines may share the folder and locks prove nothing.
enum class ClaimKind { lock, lease };

class FrameFolder {
  public:
    /// Opens the folder, or makes it.
    /// @param film  all that decides about pixels, by names that a person understands: kept in the folder as
    ///     film.json
    /// Throws InputError naming the folder for one that has another film's frames, or frames of none, or is
    /// no folder; Error for one that cannot be made.
    FrameFolder(const std::filesystem::path& folder, const nlohmann::json& film);
    /// For tests.
    FrameFolder(const std::filesystem::path& folder, const nlohmann::json& film, ClaimKind kind,
                double leaseSeconds);
    ~FrameFolder();
    FrameFolder(const FrameFolder&) = delete;
    FrameFolder& operator=(const FrameFolder&) = delete;

    /// "frame-000012.png"
    static std::string nameOf(std::size_t frame);
    std::filesystem::path pathOf(std::size_t frame) const { return folder_ / nameOf(frame); }
    bool has(std::size_t frame) const;

    /// While it lives, nobody else draws the frame.
    class Claim;
    /// Nothing where the frame is there, or somebody is drawing it.
    std::unique_ptr<Claim> claim(std::size_t frame);
    /// Removes all that the film has in the folder, and the folder if nothing else is in it, unless another
    /// process has it open.
    void removeIfAlone();

  private:
    void adopt(const nlohmann::json& film);
    void removeUselessClaims();
    std::filesystem::path folder_;
    ClaimKind kind_;
    double leaseSeconds_;
    FileHandle open_; // film.json, with a lock that others share
};

class FrameFolder::Claim {
  public:
    ~Claim();
    Claim(const Claim&) = delete;
    Claim& operator=(const Claim&) = delete;

  private:
    friend class FrameFolder;
    struct Renewal;
    Claim(std::filesystem::path path, FileHandle lock, double renewSeconds);
    std::filesystem::path path_;
    FileHandle lock_; // of kind lock
    std::unique_ptr<Renewal> renewal_;
};

} // namespace tessera
