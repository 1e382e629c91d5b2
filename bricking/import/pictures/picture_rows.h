// bricking/import/pictures/picture_rows.h: rows of grey pictures in files, by OpenImageIO. It is a target of
// its own (tessera_picture_rows), which programs load with the first such file (viewer/cli/modules/).
#pragma once

#include "bricking/import/source/slice_converter.h"

#include <cstddef>
#include <filesystem>
#include <glm/vec2.hpp>
#include <memory>
#include <span>

namespace tessera {

/// What a walk over the file's structure has found.
struct PictureShape {
    const char* format = "tiff"; // OpenImageIO's name of it
    glm::ivec2 size{0};
    FileType type = FileType::u8; // half floats: f32
    bool isPalette = false;       // pages may have a palette, which is that of grey
};

class PictureRows {
  public:
    virtual ~PictureRows() = default;
    /// `count` rows of a page from `first` on, with its numbers unchanged, in the machine's order of bytes.
    /// Rows in tiles: all of a row of tiles, or of several. Going on behind the rows before is the quick way.
    /// Throws InputError naming the file for damage, and for a page of another shape.
    virtual void read(int page, int first, int count, std::span<std::byte> out) = 0;
};

/// Throws InputError naming the file for one that is not of that format.
std::unique_ptr<PictureRows> openPictureRows(const std::filesystem::path& file, const PictureShape& shape);

} // namespace tessera
