// bricking/import/dicom/dicom_structure.h: a walk over the elements of a DICOM file, their order and their
// lengths, from the first byte to the last (PS3.5, section 7; PS3.10, section 7.1). It comes before the
// parser, which takes what it finds. A bit flipped in a tag or a length loses an element there without a
// word, and the slice is read by a default. The parser also reads beyond the end of some truncated files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace tessera {

struct DicomStructure {
    std::string syntax;                 // the transfer syntax; empty: no meta group
    std::uint64_t pixelOffsetBytes = 0; // of the pixel element's content; 0: none was found
    /// The first irregularity, in words that quote no value; empty: none. Some writers are irregular in every
    /// file, so whether it is damage is for the caller to judge.
    std::string irregularity;
    bool breaksOff = false; // an element goes beyond the end of the file: not for a parser
};

/// Of a file that begins as DICOM, with the preamble or without. A deflated data set is not walked over: what
/// it inflates to is. Throws InputError if the file cannot be read.
DicomStructure structureOf(const std::filesystem::path& file);

} // namespace tessera
