// viewer/input/volume_input.h: from what a user names (store, DICOM folder, NIfTI file, ...) to a store.
// Source files that are rendered straight away are imported once, to a cache (import_cache.h).
#pragma once

#include "bricking/import/importer.h" // ImportReport
#include "bricking/import/source/slab_source.h"
#include "core/budget.h"
#include "viewer/options/options.h"

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace tessera {

struct InputOptions {
    int series = 0;
    bool resampleZ = false;
    bool largest = false;      // a folder's largest CT, or its largest volume if there is no CT
    int phase = 0;             // of a series with several pictures at each place; 0: none chosen
    bool allowMissing = false; // files that could be slices and cannot be read are left out
    /// All that decides what is opened, as text.
    std::string key() const;
};

/// Opens source files. scratchFolder: for data whose slowest axis has to move. Throws InputError naming path,
/// also when this program was built without importers.
std::unique_ptr<SlabSource> openInput(const std::filesystem::path& path, const InputOptions& options,
                                      const std::filesystem::path& scratchFolder,
                                      const CommonOptions& common);

/// Whether path is meant as a store: a folder with a zarr.json, whole or not.
bool looksLikeStore(const std::filesystem::path& path);

struct ListedVolume {
    std::string label; // "series 2", "FILE"
    VolumeInfo info;
    std::filesystem::path path;
    int series = 0;
};
/// A row of the table of series, for machines.
struct ListedRow {
    int series = 0; // 0: not to be chosen by number
    std::string modality, what, problem;
    int slices = 0, files = 0;
    std::vector<std::string> phases;
};
struct InputListing {
    std::vector<ListedVolume> volumes; // largest first
    std::vector<ListedRow> rows;       // everything, volumes or not
    std::string table;                 // the same as lines for people
    std::string passedOver;            // files that are in no row, counted by reason; "" for none
    std::vector<std::string> reasons;  // of each such file, a word
};
/// What a folder or file offers.
InputListing listInput(const std::filesystem::path& path, bool allowMissing);

/// The store for path: itself if it is one, else its import (import_cache.h), made now if there is none. It
/// stays as long as `common`.
std::filesystem::path storeFor(const std::filesystem::path& path, const InputOptions& options, Ledger& ram,
                               const CommonOptions& common);

/// Refuses early, before long work, what importToStore() would refuse: an output that does not end in .zarr,
/// that exists without force, or that is no store. Throws InputError naming it.
void requireStorePath(const std::filesystem::path& out, bool force);
/// "HU", the one unit that presets need. Throws InputError naming --unit for anything else.
std::string parseUnit(const std::string& text);
/// One line about a finished import, more with --verbose.
void noteImport(const ImportReport& report, const SlabSource& source, const std::filesystem::path& store,
                const Ledger& ram, const CommonOptions& common);

} // namespace tessera
