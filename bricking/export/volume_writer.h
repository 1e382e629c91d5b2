// bricking/export/volume_writer.h: what writes a box of a volume as a file of one format, and the table of
// formats.
#pragma once

#include "bricking/export/box_source.h"
#include "core/base/budget.h"
#include "core/base/output_file.h" // Existing
#include "core/base/progress.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace tessera {

struct ExportRequest {
    std::filesystem::path out;
    bool compress = false;
    bool force = false; // replace an existing file or store, also one that appears meanwhile
    MemoryBudget& ram;
    Progress& progress;
    Existing existing() const { return force ? Existing::isReplaced : Existing::isKept; }
};

struct ExportReport {
    std::uint64_t bytes = 0;        // of the file or of all of them
    std::string values;             // sayValues()
    std::vector<std::string> notes; // what the format does not hold, one a line
};

/// Writes all of the box, a few slices at a time, under a temporary name that becomes `out` at the end.
/// Throws InputError for what the format cannot hold, before anything is written, and for too small a budget;
/// Error naming the file where it cannot be written; InputError where one that is kept has the name, also one
/// that appeared meanwhile. `out` is then as it was.
using WriteVolume = ExportReport(BoxSource& box, const ExportRequest& request);

struct ExportFormat {
    std::string name;                 // for --format
    std::vector<std::string> endings; // of files' names, lower case; none: by --format alone
    std::string about;
    WriteVolume* write = nullptr;
    bool compresses = false;   // --compress has an effect
    bool writesFolder = false; // `out` is a folder
};

/// In the order in which help names them.
const std::vector<ExportFormat>& exportFormats();
/// By its name, or where that is "" by the file's ending, the longest one that fits. Throws InputError naming
/// --format or the file.
const ExportFormat& exportFormatOf(const std::string& name, const std::filesystem::path& out);

// The writers.
WriteVolume writeNrrd;
WriteVolume writeNifti;             // NIfTI-1, or NIfTI-2 where a dimension is too long for it
WriteVolume writeNifti2;            // positions as doubles
WriteVolume writeVti;               // of axes at right angles
WriteVolume writeTiff;              // pages of one file; spacings alone
WriteVolume writeVdb, writeHalfVdb; // floats; whole in RAM
WriteVolume writeOmeZarr;

} // namespace tessera
