// viewer/films/frame_folder.h: the frames of one film in a folder that several processes may fill together. A
// frame exists once it has its name. The process that draws it holds a claim beside it,
// ".frame-000012.png.claim" (core/base/claims.h). Frames do not depend on the process, and get their names
// when complete.
#pragma once

#include "core/base/claims.h"
#include "core/base/files.h"

#include <cstddef>
#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace tessera {

class FrameFolder {
  public:
    /// Opens the folder, or makes it.
    /// @param film  everything that affects pixels, by readable names: kept in the folder as film.json
    /// Throws InputError naming the folder if it has another film's frames, or frames without a film, or is
    /// no folder; Error if it cannot be made.
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

    /// Null if the frame exists, or another process is drawing it.
    std::unique_ptr<Claim> claim(std::size_t frame);
    /// Removes all files of the film, and the folder if it is then empty, unless another process has it open.
    void removeIfAlone();

  private:
    void adopt(const nlohmann::json& film);
    void removeUselessClaims();
    std::filesystem::path folder_;
    Claims claims_;
    FileHandle open_; // film.json, with a shared lock
};

} // namespace tessera
