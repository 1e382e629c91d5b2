// viewer/tiles/tile_folder.cpp: see tile_folder.h.
#include "viewer/tiles/tile_folder.h"

#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/output_file.h"
#include "core/base/shown_text.h"
#include "render/pixels/kept_samples.h" // fingerprint

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <system_error>
#include <thread>
#include <utility>

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr char kPlanFile[] = "plan.json", kFinished[] = "finished-";
constexpr auto kPause = std::chrono::milliseconds(100);
constexpr int kTriesToRemove = 20;

ClaimedWork workOfTiles() {
    return {"tiles.json",
            "tile-",
            ".tile",
            "picture",
            "tiles",
            {kPlanFile},
            "choose another name for the picture, or remove this folder",
            kFinished};
}

} // namespace

TileFolder::TileFolder(const fs::path& folder, const json& record, const glm::ivec2& size, int side,
                       Progress& progress, std::function<void(const std::string&)> note)
    : grid_(size, side), folder_(folder, workOfTiles(), record), record_(record.dump(-1, ' ', true)),
      progress_(progress), note_(std::move(note)), states_(grid_.count(), State::missing) {
    // A picture that was finished before is wanted again. Who waits for that one must still see that it is.
    while (folder_.has(finishedName()))
        ++pictures_;
    report_.tiles = grid_.count();
}

/// A folder without tiles, where drawing failed before the first, stands in nobody's way.
TileFolder::~TileFolder() {
    for (std::size_t n = 0; n < grid_.count(); ++n)
        if (folder_.has(nameOf(n)))
            return;
    claim_.reset();
    finishing_.reset();
    folder_.removeIfAlone();
}

void TileFolder::begin(const Parts& plan) {
    const json parts(plan);
    folder_.agree(kPlanFile, parts,
                  "processes that share a picture need the same --ram and --gpu-memory; or " +
                      workOfTiles().hint);
    const std::string text = record_ + parts.dump(-1, ' ', true);
    key_ = fingerprint(std::as_bytes(std::span(text)));
    for (std::size_t n = 0; n < grid_.count(); ++n)
        if (folder_.has(nameOf(n)))
            mark(n, report_.there);
}

/// The file that tells the others that this picture is written.
std::string TileFolder::finishedName() const {
    return ClaimedFolder::nameOfMark(workOfTiles(), pictures_);
}

void TileFolder::mark(std::size_t tile, std::size_t& of) {
    states_[tile] = State::there;
    ++there_;
    ++of;
}

double TileFolder::share() const {
    return static_cast<double>(there_) / static_cast<double>(grid_.count());
}

std::optional<PictureTile> TileFolder::next() {
    claim_.reset();
    for (;;) {
        checkInterrupted();
        if (folder_.has(finishedName()))
            return std::nullopt;
        bool all = true;
        for (std::size_t n = 0; n < grid_.count(); ++n, at_ = (at_ + 1) % grid_.count()) {
            if (states_[at_] == State::there)
                continue;
            if ((claim_ = folder_.claim(nameOf(at_))))
                return grid_.at(at_);
            if (folder_.has(nameOf(at_)))
                mark(at_, report_.byOthers);
            else
                all = false;
        }
        if (all && (finishing_ = folder_.claim(finishedName()))) {
            if (examine())
                return std::nullopt;
            finishing_.reset();
            continue;
        }
        if (!folder_.isThere())
            throw Error(printable(folder_.pathOf("").string()) +
                        ": the folder of tiles was removed meanwhile");
        if (!std::exchange(waits_, true))
            progress_.stage(all ? "waiting for the process that writes the picture"
                                : "waiting for tiles that other processes draw");
        std::this_thread::sleep_for(kPause);
    }
}

/// Reads all tiles. Those that are not what was written go, and are drawn again: false then.
bool TileFolder::examine() {
    progress_.stage("examining the tiles");
    const ShareDone done = progress_.shares();
    opaque_ = blank_ = true;
    shown_ = 0;
    bool sound = true;
    for (std::size_t n = 0; n < grid_.count(); ++n) {
        checkInterrupted();
        const fs::path path = folder_.pathOf(nameOf(n));
        std::string why;
        const std::optional<TileFile> file = TileFile::open(path, grid_.at(n), key_, why);
        if (file)
            why = file->damage();
        if (!why.empty()) {
            note_(path.string() + ": expected a tile of this picture, found " + why + "; it is drawn again");
            std::error_code failed;
            fs::remove_all(path, failed);
            if (failed)
                throw Error(path.string() + ": cannot be removed: " + failed.message());
            states_[n] = State::missing;
            --there_;
            ++report_.damaged;
            sound = false;
            continue;
        }
        opaque_ = opaque_ && file->facts().opaque;
        blank_ = blank_ && file->facts().blank;
        shown_ += file->facts().shown;
        if (done)
            done(static_cast<double>(n + 1) / static_cast<double>(grid_.count()));
    }
    return sound;
}

void TileFolder::keep(const DrawnTile& tile) {
    TESSERA_CHECK(claim_ && grid_.at(at_) == tile.tile);
    writeTile(folder_.pathOf(nameOf(at_)), tile, key_);
    mark(at_, report_.drawn);
    claim_.reset();
}

/// Of a tile that was examined. One row of tiles is open at a time.
const TileFile& TileFolder::fileOf(std::size_t tile) const {
    if (const auto known = open_.find(tile); known != open_.end())
        return known->second;
    if (open_.size() >= static_cast<std::size_t>(grid_.across().x))
        open_.clear();
    std::string why;
    const fs::path path = folder_.pathOf(nameOf(tile));
    std::optional<TileFile> file = TileFile::open(path, grid_.at(tile), key_, why);
    if (!file)
        throw badFile(path.string(), "the tile that was there before", why);
    return open_.emplace(tile, *std::move(file)).first->second;
}

glm::vec4 TileFolder::colour(const glm::ivec2& pixel) const {
    const std::size_t number = grid_.numberOf(pixel);
    return fileOf(number).colour(pixel - grid_.at(number).from);
}

/// Calls visit(file, row of it, tile) for the tiles that a row of the picture goes through.
template <typename Visit> void TileFolder::eachTileOfRow(int row, const Visit& visit) const {
    for (int column = 0; column < grid_.across().x; ++column) {
        const std::size_t number = grid_.numberOf({column * grid_.side(), row});
        const PictureTile tile = grid_.at(number);
        visit(fileOf(number), row - tile.from.y, tile);
    }
}

void TileFolder::eachPixel(
    const std::function<void(const glm::vec4& colour, const glm::vec4& offset)>& visit) const {
    std::vector<glm::vec4> colours(static_cast<std::size_t>(grid_.side())), offsets(colours.size());
    for (int y = 0; y < grid_.picture().y; ++y) {
        checkInterrupted();
        eachTileOfRow(y, [&](const TileFile& file, int row, const PictureTile& tile) {
            const auto width = static_cast<std::size_t>(tile.size.x);
            file.readRow(row, std::span(colours).first(width), std::span(offsets).first(width));
            for (std::size_t x = 0; x < width; ++x)
                visit(colours[x], offsets[x]);
        });
    }
}

ImageRows TileFolder::rows(const std::optional<glm::vec3>& background) {
    TESSERA_CHECK(finishes());
    const auto width = static_cast<std::size_t>(grid_.picture().x);
    return {grid_.picture(), opaque_ || background.has_value(),
            [this, width, background](int first, int count) -> std::span<const glm::vec4> {
                checkInterrupted();
                band_.resize(width * static_cast<std::size_t>(count));
                for (int y = 0; y < count; ++y) {
                    const std::span band =
                        std::span(band_).subspan(width * static_cast<std::size_t>(y), width);
                    eachTileOfRow(first + y, [&](const TileFile& file, int row, const PictureTile& tile) {
                        file.readRow(row, band.subspan(static_cast<std::size_t>(tile.from.x),
                                                       static_cast<std::size_t>(tile.size.x)));
                    });
                    if (background)
                        for (glm::vec4& pixel : band)
                            pixel = overBackground(pixel, *background);
                }
                return band_;
            }};
}

void TileFolder::finish() {
    claim_.reset();
    open_.clear();
    if (finishing_)
        writeOutputFile(folder_.pathOf(finishedName()), "the picture is written\n");
    const bool mine = std::exchange(finishing_, nullptr) != nullptr;
    if (folder_.tellsWhoIsThere()) {
        // Who waits sees the picture soon, and who is killed now leaves nothing.
        for (int tries = mine ? kTriesToRemove : 1; !folder_.removeIfAlone() && --tries > 0;)
            std::this_thread::sleep_for(kPause);
        return;
    }
    // Other machines may have the folder open: the small files stay.
    std::error_code ignored;
    for (std::size_t n = 0; mine && n < grid_.count(); ++n)
        fs::remove(folder_.pathOf(nameOf(n)), ignored);
}

} // namespace tessera
