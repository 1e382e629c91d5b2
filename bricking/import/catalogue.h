// bricking/import/catalogue.h: the content of a file or folder, found in one pass over headers: volumes,
// scouts, reports, and every unused file. It also makes the table of series and chooses among them.
#pragma once

#include "bricking/import/dicom/dicom_scan.h"
#include "bricking/import/source/slab_source.h"

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

/// The class of a row. Only rows of the best class that occurs compete.
enum class CatalogueRank {
    volume, // three slices or more, or a file that is a volume
    slice,  // one or two slices, several at one position, or an object other than CT, MR or PET
    scout,  // a localizer: a projection
    none    // not a volume: a report, images without a position
};

struct CatalogueRow {
    int series = 0;             // the number for --series; 0: the only volume of a file, or none
    std::vector<int> numbers;   // of a volume in a file: what --series alone calls it at each of its phases
    bool isInFile = false;      // the series is a volume of a file of several; else DICOM
    std::filesystem::path path; // the path to open
    CatalogueRank rank = CatalogueRank::none;
    std::string modality;            // "" unknown
    int slices = 0, files = 0;       // slices of the source; files: for rows without slices
    std::optional<int> number;       // SeriesNumber of the scanner
    std::string date;                // "2023-05-17", "" unknown
    std::string folder;              // folder of its files, relative to the catalogue's path; "" itself
    std::string what;                // "scout", "dose report", a file's name
    std::string problem;             // why it is refused without options; "" if it is not
    std::optional<VolumeInfo> info;  // with its axes in the nearest LPS order; none if it is no volume
    std::vector<std::string> phases; // labels; empty: one image at each position
    std::vector<std::filesystem::path> stack; // slices that are files of the folder `path`; else empty
    std::size_t duplicates = 0;               // byte-identical copies that are dropped
};

struct Catalogue {
    std::filesystem::path path;
    DicomScan scan; // its `passed` has every skipped file
    std::vector<CatalogueRow> rows;
};

/// Reads headers. Throws InputError only if there is nothing at the path.
/// @param options  allowMissing and spacingMm, for what the rows say
Catalogue lookThrough(const std::filesystem::path& path, const SourceOptions& options = {});

/// The row by the options: by number, the largest, or the only one (the only row of the best class, or its
/// only CT). Throws InputError with the table if the user must choose, and with the content of the folder if
/// there is nothing to choose. A scout is taken by its number only. Without a phase --series may be the
/// number of any time of a volume in a file, with one that of its first.
const CatalogueRow& chooseRow(const Catalogue& catalogue, const SourceOptions& options);

/// The phase that a volume of several is opened at, from 1; 0: it has one, or the options choose none and
/// nothing else does.
int phaseOf(const CatalogueRow& row, const SourceOptions& options);

/// Opens a row, its axes in the nearest LPS order. Throws InputError as the format's importer does.
std::unique_ptr<SlabSource> openRow(const Catalogue& catalogue, const CatalogueRow& row,
                                    const SourceOptions& options);

/// True for a file of a format whose files may have several levels.
bool mayHaveLevels(const std::filesystem::path& path);
/// The levels of a row's file, finest first, axes in nearest LPS order; none: it has one. Reads headers.
/// Throws InputError naming a level that cannot be opened.
std::vector<VolumeInfo> fileLevelsOf(const Catalogue& catalogue, const CatalogueRow& row,
                                     const SourceOptions& options);

/// A line of headings and one for each row, without header texts that could hold a name. Empty columns are
/// left out: numbers and dates that no header has, folders if all files are in one. Ends without a line
/// break.
std::string tableOf(const Catalogue& catalogue);

/// Files with voxels that the headers at a path name: of a file, or of all files below a folder. A header
/// that cannot be read names none.
std::vector<std::filesystem::path> namedFilesOf(const std::filesystem::path& path);

/// "series 2 (CT, 2 slices: scout), 1 dose report, 2 empty (a, b)": everything that opening this row skips;
/// "" for nothing.
std::string passedOverText(const Catalogue& catalogue, const CatalogueRow& row);
/// True if that includes files that are not excluded by their names.
bool passesOverSomething(const Catalogue& catalogue, const CatalogueRow& row);

} // namespace tessera
