// bricking/import/dicom/dicom_pixels.h: reads the stored numbers of one slice. Plain pixels are read by
// position; compressed ones are decoded from the stream's fragments. Memory: one slice.
#pragma once

#include "bricking/import/codecs/stream.h"
#include "bricking/import/dicom/dicom_scan.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace tessera {

// The stored values of a slice from a decoded stream's samples. The stream's own header and the tags may
// disagree about sign and precision. Rules: docs/formats.md, "Compressed streams".

/// Findings in compressed slices, for all slices together.
struct StreamFindings {
    std::uint64_t clamped = 0; // samples of lossy streams beyond the stored range, clamped
    bool lossy = false;        // some stream is
    std::string disagreement;  // the first contradiction between a stream and the tags; empty: none
    std::string beyond;        // words with bits beside the stored ones, of the first such slice; empty: none
    std::string mended;        // the first repair of a stream; empty: none
    /// Of a later slice.
    void add(const StreamFindings& later);
};

/// Converts a stream's samples to stored values, in place. Throws InputError naming the file if both
/// interpretations contradict the tags.
void fitToTags(const StreamHeader& stream, const DicomSlice& slice, std::span<std::int32_t> values,
               StreamFindings& findings);

/// Throws InputError naming the file unless stream and tags agree in size and in the number of components.
void checkShape(const StreamHeader& stream, const DicomSlice& slice);

class DicomPixels {
  public:
    /// Reads slice.rows * slice.columns stored values, [y][x], overlay bits removed and sign extended.
    /// Throws InputError naming the file if it is truncated, if its stream is damaged or contradicts the
    /// tags in size, and if it cannot be decoded.
    void read(const DicomSlice& slice, std::span<std::int32_t> out);
    /// Of all slices that this one has read.
    const StreamFindings& findings() const { return findings_; }

  private:
    void decode(const DicomSlice& slice, std::span<std::int32_t> out);

    std::vector<std::byte> buffer_;
    StreamFindings findings_;
};

} // namespace tessera
