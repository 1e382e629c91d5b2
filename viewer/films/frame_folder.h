// viewer/films/frame_folder.h: the frames of one film in a folder that several processes may fill together
// (viewer/claims/claimed_folder.h).
#pragma once

#include "viewer/claims/claimed_folder.h"

#include <cstddef>
#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace tessera {

class FrameFolder {
  public:
    /// As ClaimedFolder.
    /// @param film  everything that affects pixels, by readable names: kept in the folder as film.json
    FrameFolder(const std::filesystem::path& folder, const nlohmann::json& film)
        : frames_(folder, work(), film) {}
    /// For tests.
    FrameFolder(const std::filesystem::path& folder, const nlohmann::json& film, ClaimKind kind,
                double leaseSeconds)
        : frames_(folder, work(), film, kind, leaseSeconds) {}

    /// "frame-000012.png"
    static std::string nameOf(std::size_t frame) { return ClaimedFolder::nameOf(work(), frame); }
    std::filesystem::path pathOf(std::size_t frame) const { return frames_.pathOf(nameOf(frame)); }
    bool has(std::size_t frame) const { return frames_.has(nameOf(frame)); }

    /// Null if the frame exists, or another process is drawing it.
    std::unique_ptr<Claim> claim(std::size_t frame) { return frames_.claim(nameOf(frame)); }
    void removeIfAlone() { frames_.removeIfAlone(); }

  private:
    static ClaimedWork work() { return {"film.json", "frame-", ".png", "film", "frames"}; }
    ClaimedFolder frames_;
};

} // namespace tessera
