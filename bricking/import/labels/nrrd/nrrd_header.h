// bricking/import/labels/nrrd/nrrd_header.h: the header of an NRRD file (NRRD0001 to NRRD0005), attached or
// detached. Private to the NRRD reader.
#pragma once

#include "bricking/import/source/slice_converter.h"
#include "bricking/import/source/source_files.h"

#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

enum class NrrdEncoding : std::uint8_t { raw, gzip, text };

struct NrrdHeader {
    std::vector<std::int64_t> sizes; // of the axes, the fastest first; 1 to kMostNrrdAxes, each at least 1
    FileType type = FileType::u8;
    bool bigEndian = false;
    NrrdEncoding encoding = NrrdEncoding::raw;
    std::int64_t lineSkip = 0, byteSkip = 0; // before the data of each file; byteSkip -1: they are its end
    std::string space;                       // "left-posterior-superior"; "" none
    std::vector<std::optional<glm::dvec3>> directions; // of each axis; nullopt: "none"; empty: no such field
    std::optional<glm::dvec3> origin;                  // of the first voxel's centre
    std::vector<double> spacings;                      // of each axis; NaN: unknown; empty: no such field
    std::vector<std::string> kinds, spaceUnits;        // empty: no such field
    /// Of a detached header. Empty: the data follow the header.
    std::vector<std::filesystem::path> dataFiles;
    std::map<std::string, std::string> pairs; // key:=value, with escapes undone
    std::uint64_t bytes = 0;                  // of the header, blank line included
};

inline constexpr std::size_t kMostNrrdAxes = 16;
inline constexpr std::size_t kMostNrrdHeaderBytes = std::size_t{16} << 20;

/// True if a file begins as NRRD.
bool beginsAsNrrd(const InputFile& file);

/// Reads the header alone. Throws InputError naming the file for a header that is no NRRD's, is damaged or
/// ends early, lacks a required field, or says what the reader does not know (blocks, bzip2, hex). Unknown
/// fields are passed over. Of a pattern or a list of data files at most one a row of the volume is accepted.
NrrdHeader readNrrdHeader(const InputFile& file);

} // namespace tessera
