// bricking/import/labels/seg/seg_object.h: what the header of a DICOM Segmentation says: its frames' places
// and segments, and where its pixels are. Private to the reader of segmentations.
#pragma once

#include "bricking/labels/label_table.h"

#include <cstdint>
#include <filesystem>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

enum class SegKind : std::uint8_t { binary, fractional, labelmap };
enum class SegCoding : std::uint8_t { plain, framesPlain, rle, jpeg, jpegLs, jpeg2000 };

struct SegFrame {
    glm::dvec3 positionMm{0};  // of the centre of its first pixel
    std::uint32_t segment = 0; // SegmentNumber; 0 of a label map
};

struct SegObject {
    std::filesystem::path file;
    SegKind kind = SegKind::binary;
    int rows = 0, columns = 0;
    int bitsAllocated = 1;        // 1, 8 or 16
    std::vector<SegFrame> frames; // as the pixels follow each other; at least one
    std::vector<Label> segments;  // ascending by value
    glm::dvec3 rowDirection{1, 0, 0}, columnDirection{0, 1, 0}; // of unit length
    glm::dvec2 spacingMm{1};                                    // along a row, along a column
    double betweenSlicesMm = 0, thicknessMm = 0;                // 0 unknown
    std::uint32_t halfValue = 1;                                // of a fractional one: the least value inside
    std::optional<std::uint32_t> padding; // of a label map: the value of pixels of no segment
    std::string frameOfReference;         // "" unknown
    // The pixels.
    SegCoding coding = SegCoding::plain;
    bool isDeflated = false;
    std::uint64_t pixelOffsetBytes = 0; // in the file, or in the plain file that a deflated one inflates to
    std::vector<std::string> notes;
};

/// True if a file begins as a DICOM Segmentation, of surfaces too. Throws nothing.
bool isSegmentation(const std::filesystem::path& file);

/// Reads the header alone. Throws InputError naming the file for a file that breaks off, for an object that
/// is no segmentation of pixels, and for a header that lacks what the reader needs, contradicts itself or the
/// length of the pixels, or places frames in different orientations. Nothing of the patient is read.
SegObject readSegObject(const std::filesystem::path& file);

} // namespace tessera
