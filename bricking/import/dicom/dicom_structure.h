// bricking/import/dicom/dicom_structure.h: checks order and lengths of all elements of a DICOM file, from the
// first byte to the last (PS3.5, section 7; PS3.10, section 7.1). It comes before the parser, which is
// lenient. A bit flipped in a tag or a length makes the parser lose an element silently, so that a default is
// used. The parser also reads beyond the end of some truncated files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace tessera {

struct DicomStructure {
    std::string syntax;                 // the transfer syntax; empty: no meta group
    std::uint64_t pixelOffsetBytes = 0; // of the pixel element's content; 0: none was found
    /// The first irregularity, in words that quote no value; empty: none. Some writers are irregular in every
    /// file, so the caller decides whether it is damage.
    std::string irregularity;
    /// Elements and items, at least as many as there are; 0: the check stopped before the file's end.
    std::uint64_t elements = 0;
    bool breaksOff = false; // an element extends beyond the end of the file: no parser may read it
};

/// Checks a file that begins as DICOM, with or without the preamble. Of a deflated data set the inflated data
/// are checked instead. Throws InputError if the file cannot be read.
DicomStructure structureOf(const std::filesystem::path& file);

} // namespace tessera
