// bricking/import/dicom_pixels.h: the stored numbers of one slice: read by position where they lie plainly,
// else decoded by vtk-dicom. One slice in memory.
#pragma once

#include "bricking/import/dicom_scan.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tessera {

class DicomPixels {
  public:
    /// Reads slice.rows * slice.columns stored values, [y][x], overlay bits removed and sign extended.
    /// Throws InputError naming the file if it is truncated or cannot be decoded.
    void read(const DicomSlice& slice, std::span<std::int32_t> out);

  private:
    std::vector<std::byte> buffer_;
};

} // namespace tessera
