// bricking/import/labels/seg/seg_pixels.h: the pixels of a DICOM Segmentation, frame by frame in any order.
// Private to the reader of segmentations.
#pragma once

#include "bricking/import/dicom/encapsulated_frames.h"
#include "bricking/import/labels/seg/seg_object.h"
#include "bricking/import/source/source_files.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace tessera {

class SegPixels {
  public:
    /// Of compressed pixels it finds the frames. Throws InputError naming the file where they are not there.
    /// @param scratchFolder  for a deflated file, which is inflated to a spool
    SegPixels(const SegObject& seg, const std::filesystem::path& scratchFolder);

    /// The pixels inside, a bit each, [y][x], the lowest bit first. out.size() is maskWords().
    /// Throws InputError naming the file for damage.
    void readMask(std::size_t frame, std::span<std::uint64_t> out);
    std::size_t maskWords() const { return (pixels_ + 63) / 64; }
    /// Of a label map: values, [y][x].
    void readValues(std::size_t frame, std::span<std::uint16_t> out);

  private:
    void checkRoom() const;
    void readAt(std::uint64_t offset, std::span<std::byte> out) const;
    void readBits(std::size_t frame, std::span<std::uint64_t> out);

    const SegObject& seg_;
    InputFile file_;
    std::unique_ptr<SpoolFile> spool_;
    std::uint64_t pixels_;                         // of a frame
    std::vector<std::vector<Fragment>> fragments_; // of each frame; empty: not compressed
    std::vector<std::byte> bytes_;
    std::vector<std::uint16_t> values_;
    std::vector<std::int32_t> decoded_;
};

} // namespace tessera
