// bricking/import/files/stack/picture_walk.h: walks over the structure of TIFF, PNG and JPEG 2000 files
// before a library reads their pixels: size and type of every page, and that all its data lie in the file.
// Private to stacks.
#pragma once

#include "bricking/import/pictures/picture_rows.h"
#include "bricking/import/source/source_files.h"

#include <cstdint>
#include <filesystem>
#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <string>

namespace tessera {

/// What pages have that can be slices: one number a pixel, of 8 to 64 bits.
struct PictureHead {
    PictureShape shape;
    int pages = 1;
    int tileRows = 0;        // rows of a tile; 0: rows one after another
    int stripRows = 0;       // rows of a TIFF that are packed together; 0: none are
    bool isLossy = false;    // JPEG, JPEG 2000
    std::string description; // TIFF's ImageDescription, of the first page
    /// Pixels per unit of length along x and y, and millimetres of the unit; 0: of a unit that is not said.
    std::optional<glm::dvec2> perUnit;
    double unitMm = 0;
    bool bigEndian = false, isHalf = false; // order of bytes in a TIFF; floats of 16 bits
    /// Where a page's pixels begin that are not packed and in one run.
    std::optional<std::uint64_t> runOffset;
};

/// Throws InputError naming the file, of TIFF the page: for another format, damage, data beyond the end of
/// the file, sizes that its data cannot hold, and whatever is no slice: several channels, colours, palettes,
/// other orders of rows, other numbers of bits, pages that differ.
PictureHead walkPicture(const InputFile& file);

/// Of the first page of a TIFF file, which may be no slice.
struct TiffBeginning {
    bool isFollowed = false; // by another page
    std::string description; // TIFF's ImageDescription
};
/// Of another file: nothing.
TiffBeginning tiffBeginningOf(const InputFile& file);

/// PictureShape::format of files that OpenImageIO does not read here.
inline constexpr const char* kJpeg2000 = "JPEG 2000";

// The formats.
bool beginsAsTiff(const InputFile& file);
PictureHead walkTiff(const InputFile& file);
PictureHead walkPng(const InputFile& file);
/// Of a PNG that was walked over: reads all of it. Throws InputError naming the file for a checksum that does
/// not fit.
void checkPngSums(const InputFile& file);

/// JP2 files and codestreams without a frame, of 2^26 pixels at most.
bool beginsAsJpeg2000(const InputFile& file);
PictureHead walkJpeg2000Picture(const InputFile& file);
/// Rows of a picture that was walked over, decoded as a whole: some 12 bytes a pixel meanwhile, 4 afterwards.
/// Throws InputError naming the file for every complaint of the decoder.
std::unique_ptr<PictureRows> openJpeg2000Rows(const std::filesystem::path& file, const PictureShape& shape);

} // namespace tessera
