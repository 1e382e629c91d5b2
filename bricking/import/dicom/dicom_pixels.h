// bricking/import/dicom/dicom_pixels.h: reads the stored numbers of one slice. Plain pixels are read by
// position; compressed ones are decoded from the stream's fragments. Memory: one slice.
#pragma once

#include "bricking/import/dicom/dicom_scan.h"
#include "bricking/import/dicom/stream_values.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tessera {

class DicomPixels {
  public:
    /// Reads slice.rows * slice.columns stored values, [y][x], overlay bits removed and sign extended.
    /// Throws InputError naming the file if it is truncated, if its stream is damaged or contradicts the
    /// tags in size, and if it cannot be decoded.
    void read(const DicomSlice& slice, std::span<std::int32_t> out);
    /// For all slices read so far.
    const StreamFindings& findings() const { return findings_; }

  private:
    void decode(const DicomSlice& slice, std::span<std::int32_t> out);

    std::vector<std::byte> buffer_;
    StreamFindings findings_;
};

} // namespace tessera
