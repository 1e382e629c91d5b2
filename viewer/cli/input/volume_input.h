// viewer/cli/input/volume_input.h: opens a path of the user (store, DICOM folder, NIfTI file, ...) as a
// store. Source files that are rendered directly are imported once, to a cache (import_cache.h).
#pragma once

#include "bricking/import/importer.h" // ImportReport
#include "bricking/import/source/slab_source.h"
#include "core/base/budget.h"
#include "core/base/volume.h"
#include "core/scene/scene.h"
#include "viewer/cli/options/command.h"
#include "viewer/cli/options/options.h"

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

struct InputOptions : SourceChoice {
    InputOptions() = default;
    explicit InputOptions(const SourceChoice& choice) : SourceChoice(choice) {}
    bool allPhases = false; // --phase all: of commands that take it
    /// All options that affect the import, as text.
    std::string key() const;
};

enum class ChoiceNote { given, omitted };
/// Opens source files; a level that is not said is the finest. scratchFolder: for data whose slowest axis
/// changes. Throws InputError naming path, also when this program was built without importers.
/// @param note  of what was chosen among several volumes, and what was skipped
std::unique_ptr<SlabSource> openInput(const std::filesystem::path& path, const InputOptions& options,
                                      const std::filesystem::path& scratchFolder, const CommonOptions& common,
                                      ChoiceNote note = ChoiceNote::given);

/// True if path is meant as a store: a folder with a zarr.json, valid or not; or the address of one, which
/// throws InputError when it is out of reach.
bool looksLikeStore(const std::filesystem::path& path);

struct ListedVolume {
    std::string label; // "series 2", "FILE"
    VolumeInfo info;
    std::filesystem::path path;
    int series = 0;
    std::vector<VolumeInfo> levels; // of its file, finest first; none: it has one
    std::string levelsProblem;      // why they are not known; "": they are
};
/// A row of the table of series, as data.
struct ListedRow {
    int series = 0; // 0: cannot be chosen by number
    std::string modality, date, folder, what, problem;
    std::optional<int> number; // SeriesNumber
    int slices = 0, files = 0;
    std::vector<std::string> phases;
};
struct InputListing {
    std::vector<ListedVolume> volumes; // in the order of the rows
    std::vector<ListedRow> rows;       // all rows, volumes or not
    std::string table;                 // the same as lines for people
    std::string passedOver;            // files in no row, counted by reason; "" for none
    std::vector<std::string> reasons;  // the reason of each such file, a word
};
/// The content of a folder or file.
InputListing listInput(const std::filesystem::path& path, const SourceChoice& choice);

/// The store for path: itself if it is one, else its import (import_cache.h), made now if there is none. It
/// stays as long as `common`. Throws InputError for a series, phase, level or box of a store.
std::filesystem::path storeFor(const std::filesystem::path& path, const InputOptions& options,
                               MemoryBudget& ram, const CommonOptions& common);

/// A store is one volume: options that request another one throw InputError; options without effect give a
/// note.
void requireNoChoice(const std::filesystem::path& store, const InputOptions& options,
                     const CommonOptions& common);
/// The store of a scene's volume; given options override the scene's choice of source.
std::filesystem::path storeFor(const SceneVolume& volume, const InputOptions& named, MemoryBudget& ram,
                               const CommonOptions& common);

/// Early check for importToStore(): refuses an output that does not end in .zarr, that exists without force,
/// or that is no store. Throws InputError naming it.
void requireStorePath(const std::filesystem::path& out, bool force);
/// The unit of an import: "HU" or "SUVbw". Throws InputError naming --unit for anything else.
std::string parseUnit(const std::string& text);
/// One line about a finished import, more with --verbose.
void noteImport(const ImportReport& report, const SlabSource& source, const std::filesystem::path& store,
                const MemoryBudget& ram, const CommonOptions& common);

// Notes about an import: voxels that it changed or could not read.

/// "1234 voxels without a number (NaN or infinite), stored as the lowest value, -1000 HU";
/// nonFiniteVoxels > 0.
std::string sayAbsent(const VolumeInfo& info);
/// "with loss, ratio 8.2 as the header says"; lossy.
std::string sayLoss(const VolumeInfo& info);
/// A note on pictures of label maps; "" for other volumes.
std::string sayLabels(const VolumeInfo& info);
/// All notes on a volume, one per line.
std::vector<std::string> sayChanges(const VolumeInfo& info);

// The options that choose among source files, the same for every command.

/// @param all  --phase takes the word, too
enum class PhaseWords { numbers, all };
void addSelectionOptions(Command& command, InputOptions& input, PhaseWords words = PhaseWords::numbers);
/// --spacing X,Y,Z alone. Throws InputError naming it for other than three lengths above 0.
void addSpacingOption(Command& command, SourceChoice& choice);

} // namespace tessera
