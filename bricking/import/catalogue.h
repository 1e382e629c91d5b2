// bricking/import/catalogue.h: everything that a file or folder offers, found in one pass over headers:
// volumes, scouts, reports, and every unused file. It also makes the table of series and the
// choice among them.
#pragma once

#include "bricking/import/dicom/dicom_scan.h"
#include "bricking/import/source/slab_source.h"
#include "bricking/import/source/source_options.h"

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

/// How much like a volume a row is. The best rank that is there competes; the others never do.
enum class CatalogueRank {
    volume, // three slices or more, or a file that is a volume
    slice,  // one or two slices, all at one place, or an object that is no CT, MR or PET
    scout,  // a localizer: a shadow picture
    none    // nothing that could be opened: a report, images without a position
};

struct CatalogueRow {
    int series = 0;             // DICOM: the number for --series; 0: a file of its own, or none
    std::filesystem::path path; // what is opened
    CatalogueRank rank = CatalogueRank::none;
    std::string modality;            // "" unknown
    int slices = 0, files = 0;       // files: of rows that hold no slices
    std::optional<int> number;       // SeriesNumber, as scanners and reports count
    std::string date;                // "2023-05-17", "" unknown
    std::string folder;              // where its files lie, below the catalogue's path; "" there itself
    std::string what;                // "scout", "dose report", a file's name
    std::string problem;             // why it is refused as it is; "" if it is not
    std::optional<VolumeInfo> info;  // with its axes in the nearest LPS order; none where it is no volume
    std::vector<std::string> phases; // labels; empty: one picture at each place
    std::size_t duplicates = 0;      // byte-identical copies that are dropped
};

struct Catalogue {
    std::filesystem::path path;
    DicomScan scan; // its `passed` has every file that is passed over
    std::vector<CatalogueRow> rows;
};

/// Looks through headers. Throws InputError only where nothing is at the path.
/// @param allowMissing  as SourceOptions::allowMissing, for what the rows say
Catalogue lookThrough(const std::filesystem::path& path, bool allowMissing = false);

/// The row that the options choose: by number, the largest, or the only one: of the best rank the only row,
/// or of several the only CT. Throws InputError with the table where a choice is needed, and with what was
/// found where there is nothing to choose. A scout is taken by its number only.
const CatalogueRow& chooseRow(const Catalogue& catalogue, const SourceOptions& options);

/// Opens a row, its axes in the nearest LPS order. Throws InputError as the format's importer does.
std::unique_ptr<SlabSource> openRow(const Catalogue& catalogue, const CatalogueRow& row,
                                    const SourceOptions& options);

/// One line for each row with a line of headings; of headers no text that could hold a name. Columns that
/// tell nothing (numbers and dates where no header has any, folders where all lie in one) are left out. Ends
/// without a line break.
std::string tableOf(const Catalogue& catalogue);

/// "series 2 (CT, 2 slices: scout), 1 dose report, 2 empty (a, b)": all that opening this row
/// passes over; "".
std::string passedOverText(const Catalogue& catalogue, const CatalogueRow& row);
/// Whether that is more than files whose names say that they are no slices.
bool passesOverSomething(const Catalogue& catalogue, const CatalogueRow& row);

} // namespace tessera
