// viewer/tiles/tile_file.h: a tile of a picture on disk: its colours as they are in memory, and what was
// added to them. Whatever is not the whole file that was written is told from it.
#pragma once

#include "core/base/files.h"
#include "core/image/image.h"
#include "core/image/picture_tile.h"
#include "render/picture_tiles.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>
#include <optional>
#include <span>
#include <string>

namespace tessera {

// The file: a line of text that names the kind; a header of 64 bytes, little-endian: the tile's first column
// and row, columns, rows, pictures besides the colours (1: what is added to them; 2: offsets of means; 3:
// both), bits (1: no alpha of the sum is below 1; 2: it is blank), pixels whose colours show something (8
// bytes), the key of the work (16 characters), 16 bytes of 0; of each picture, colours first, the pixels row
// by row, four floats each; the CRC-32C of all that, 4 bytes.

/// What its header says of a tile.
struct TileFacts {
    PictureTile tile;
    bool added = false, offsets = false; // there are such pictures
    bool opaque = false, blank = false;  // of the colours and what is added
    std::size_t shown = 0;               // pixels whose colours show something
};

/// Throws Error naming the file.
/// @param key  of the work that the tile is of, 16 characters
void writeTile(const std::filesystem::path& path, const DrawnTile& drawn, const std::string& key);

class TileFile {
  public:
    /// Opens the file of a tile.
    /// @param why  gets the reason where there is none: another file, a part of one, of another work or place
    static std::optional<TileFile> open(const std::filesystem::path& path, const PictureTile& tile,
                                        const std::string& key, std::string& why);
    const TileFacts& facts() const { return facts_; }
    /// Reads all of it. Returns what is wrong; empty: nothing.
    std::string damage() const;
    /// A row, from 0 on: the picture's colours, with what is added to them. Throws InputError naming the file
    /// if it is not there.
    void readRow(int row, std::span<glm::vec4> out) const;
    /// The same of the colours without that, and of their offsets, which are 0 where there are none.
    void readRow(int row, std::span<glm::vec4> colours, std::span<glm::vec4> offsets) const;
    /// The colours of a pixel, by its place in the tile, without what is added.
    glm::vec4 colour(const glm::ivec2& at) const;

  private:
    TileFile(std::filesystem::path path, FileHandle file) : path_(std::move(path)), file_(std::move(file)) {}
    void read(std::uint64_t offset, std::span<std::byte> bytes) const;
    std::uint64_t offsetOf(int picture, const glm::ivec2& at) const;
    std::filesystem::path path_;
    FileHandle file_;
    TileFacts facts_;
};

} // namespace tessera
