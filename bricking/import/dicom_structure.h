// bricking/import/dicom_structure.h: walks over the elements of a DICOM file, their order and their lengths,
// from the first byte to the last (PS3.5, section 7; PS3.10, section 7.1). The parser takes what it finds; a
// bit that flipped in a tag or a length loses an element there without a word, and a slice is then read by a
// default.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace tessera {

/// What a parser found out about the same file.
struct DicomLayout {
    bool bigEndian = false, implicit = false; // of the data set
    std::uint64_t pixelOffsetBytes = 0;       // of the pixel element's content
    std::uint64_t pixelLengthBytes = 0;       // encapsulated: not used
    bool encapsulated = false;
};

/// The first irregularity, in words that quote no value; empty: none. Some writers are irregular in every
/// file, so whether it is damage is for the caller to judge. Throws InputError if the file cannot be read.
std::string irregularityOf(const std::filesystem::path& file, const DicomLayout& layout);
/// The same for a file in memory.
std::string irregularityOf(std::span<const std::byte> bytes, const DicomLayout& layout);

} // namespace tessera
