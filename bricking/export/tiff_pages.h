// bricking/export/tiff_pages.h: a TIFF file of equal grey pages, written from its beginning to its end.
// Rules: TIFF 6.0; BigTIFF where 4 GiB do not suffice. Pages of whole slices are one strip, so that programs
// can map them; deflated ones (Compression 8) are strips of a quarter of a megabyte.
#pragma once

#include "bricking/export/volume_file.h"
#include "bricking/import/source/slice_converter.h" // FileType

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/vec2.hpp>
#include <span>
#include <string>
#include <vector>

namespace tessera {

struct TiffLayout {
    glm::ivec2 size{0}; // pixels of a page
    int pages = 1;
    FileType type = FileType::u8; // u8, i16, u16 or f32
    glm::dvec2 pixelMm{1};        // along x and y
    std::string description;      // of the first page
    bool isPacked = false;
    bool isBig = false; // BigTIFF even where 4 GiB suffice
};

class TiffPages {
  public:
    TiffPages(const std::filesystem::path& path, TiffLayout layout, Existing existing = Existing::isReplaced);
    /// Pixels of the pages, one after another.
    void append(std::span<const std::byte> pixels);
    /// After the last pixel.
    void finish();
    std::uint64_t size() const { return file_.size(); }
    bool isBig() const { return isBig_; }
    /// Memory of strips and their table.
    static std::size_t bytesNeeded(const TiffLayout& layout);

  private:
    void writeDirectories();
    void flushStrip();
    std::uint64_t pageBytes() const;
    int stripsOfPage() const;

    TiffLayout layout_;
    int rowsPerStrip_;
    bool isBig_;
    VolumeFile file_;
    std::vector<std::byte> strip_, packed_;
    std::uint64_t pixelsBegin_, inPage_ = 0;
    std::vector<std::uint64_t> offsets_, sizes_; // of deflated strips, page by page
};

} // namespace tessera
