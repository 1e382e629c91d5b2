// viewer/tiles/tile_folder.h: the tiles of one picture in a folder that several processes may fill together,
// and the picture's rows once all are there. One of the processes finishes the picture; if it ends without,
// another one does.
#pragma once

#include "core/base/progress.h"
#include "render/picture_tiles.h"
#include "viewer/claims/claimed_folder.h"
#include "viewer/tiles/tile_file.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

namespace tessera {

class TileFolder final : public PictureTiles {
  public:
    /// Opens the folder, or makes it.
    /// @param record  everything that pixels depend on besides the plan, by readable names
    /// @param note    gets what is said to the user: of tiles that are damaged
    /// Throws as ClaimedFolder does.
    TileFolder(const std::filesystem::path& folder, const nlohmann::json& record, const glm::ivec2& size,
               int side, Progress& progress, std::function<void(const std::string&)> note);
    ~TileFolder() override;

    int side() const override { return grid_.side(); }
    void begin(const Parts& plan) override;
    std::optional<PictureTile> next() override;
    void keep(const DrawnTile& tile) override;
    double share() const override;
    bool finishes() const override { return finishing_ != nullptr; }
    std::size_t shown() const override { return shown_; }
    glm::vec4 colour(const glm::ivec2& pixel) const override;
    void eachPixel(
        const std::function<void(const glm::vec4& colour, const glm::vec4& offset)>& visit) const override;

    /// Where this process finishes the picture: all rows are on a background, if there is one. Its tiles stay
    /// open; RAM is that of the rows that are asked for.
    /// @param background  linear; none: nothing
    ImageRows rows(const std::optional<glm::vec3>& background);
    bool blank() const { return blank_; }
    /// The picture is written: tells the others, and removes the tiles, and the folder with the last process
    /// that has it open.
    void finish();

    struct Report {
        std::size_t tiles = 0, there = 0; // in all; those that were there at first
        std::size_t drawn = 0, byOthers = 0, damaged = 0;
    };
    const Report& report() const { return report_; }

  private:
    enum class State : std::uint8_t { missing, there };
    std::string nameOf(std::size_t tile) const { return folder_.nameOf(tile); }
    bool examine();
    void mark(std::size_t tile, std::size_t& of);
    std::string finishedName() const;
    const TileFile& fileOf(std::size_t tile) const;
    template <typename Visit> void eachTileOfRow(int row, const Visit& visit) const;

    TileGrid grid_;
    ClaimedFolder folder_;
    std::string record_, key_; // of the work
    Progress& progress_;
    std::function<void(const std::string&)> note_;
    std::vector<State> states_;
    std::size_t there_ = 0;    // of these
    std::size_t at_ = 0;       // where the next missing tile is looked for
    std::size_t pictures_ = 0; // that were finished in the folder before this process came
    bool waits_ = false, opaque_ = false, blank_ = false;
    std::size_t shown_ = 0;
    std::unique_ptr<Claim> claim_, finishing_;
    Report report_;
    std::vector<glm::vec4> band_;
    mutable std::unordered_map<std::size_t, TileFile> open_; // of the row of tiles at hand
};

} // namespace tessera
