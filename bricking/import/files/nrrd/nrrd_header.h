// bricking/import/files/nrrd/nrrd_header.h: the header of an NRRD file (NRRD0001 to NRRD0005), attached or
// detached. For volumes and labels.
#pragma once

#include "bricking/import/files/data_files.h"
#include "bricking/import/source/source_files.h"

#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

struct NrrdHeader : DataFiles {                        // of 1 to kMostNrrdAxes axes
    std::string space;                                 // "left-posterior-superior"; "" none
    std::vector<std::optional<glm::dvec3>> directions; // of each axis; nullopt: "none"; empty: no such field
    std::optional<glm::dvec3> origin;                  // of the first voxel's centre
    std::vector<double> spacings;                      // of each axis; NaN: unknown; empty: no such field
    std::vector<std::string> kinds, spaceUnits, units; // empty: no such field
    std::string sampleUnits;                           // of the values; "": no such field
    std::map<std::string, std::string> pairs;          // key:=value, with escapes undone
};

inline constexpr std::size_t kMostNrrdAxes = 16;

/// True if a file begins as NRRD.
bool beginsAsNrrd(const InputFile& file);

/// Reads the header alone. Throws InputError naming the file for a header that is no NRRD's, is damaged or
/// ends early, lacks a required field, or says what the reader does not know (blocks, bzip2, hex). Unknown
/// fields are passed over. Of a pattern or a list of data files at most one a row of the volume is accepted.
NrrdHeader readNrrdHeader(const InputFile& file);

} // namespace tessera
