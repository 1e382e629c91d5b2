// viewer/cli/input/volume_input.cpp: see volume_input.h.
#include "viewer/cli/input/volume_input.h"

#include "bricking/import/source/voxel_tally.h" // kLabelMapRemark
#include "bricking/store/remote_files.h"
#include "bricking/store/store_files.h"
#include "bricking/store/store_reader.h" // isStore
#include "bricking/store/zarr_metadata.h"
#include "core/base/address.h"
#include "core/base/error.h"
#include "core/base/shown_text.h"
#include "viewer/cli/input/file_level.h"
#include "viewer/cli/input/import_cache.h"
#include "viewer/cli/input/remote_input.h"
#include "viewer/cli/options/options.h" // formatNumber
#if TESSERA_WITH_IMPORT
#include "bricking/import/catalogue.h"
#endif

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <optional>
#include <vector>

namespace tessera {
namespace {

namespace fs = std::filesystem;

void requireExisting(const fs::path& path) {
    std::error_code ignored;
    if (!isAddress(path) && !fs::exists(path, ignored))
        throw badFile(path.string(), "a file or folder", "nothing there");
}

} // namespace

std::string InputOptions::key() const {
    // Every member affects the result of an import. A new member must be named here, otherwise this does not
    // compile.
    const auto& [number, isResampled, isLargest, phaseNumber, mayMiss, mm, level, box] =
        static_cast<const SourceChoice&>(*this);
    std::string part;
    if (level.value_or(0) != 0)
        part += "|level " + std::to_string(*level);
    if (box)
        part += "|box " + formatExtent(box->low) + " to " + formatExtent(box->high);
    return std::to_string(number) + "|" + std::to_string(isResampled) + "|" + std::to_string(isLargest) +
           "|" + std::to_string(phaseNumber) + "|" + std::to_string(mayMiss) +
           (mm ? "|" + numberText(mm->x, 17) + "," + numberText(mm->y, 17) + "," + numberText(mm->z, 17)
               : "") +
           part;
}

bool looksLikeStore(const fs::path& path) {
    if (isAddress(path)) {
        const fs::path at = reached(path);
        const auto text = readText(openFolder(at), "zarr.json", at, kMaxMetadataBytes);
        return text && isGroupOfOurs(*text);
    }
    std::error_code ignored;
    if (path.extension() == ".zarr" && !fs::exists(path, ignored)) // a program died while it replaced it
        recoverFolders(path.has_parent_path() ? path.parent_path() : fs::path("."));
    if (!fs::is_regular_file(path / "zarr.json", ignored)) // the reader reports other types
        return fs::exists(path / "zarr.json", ignored) && !fs::is_directory(path / "zarr.json", ignored);
    std::ifstream file(path / "zarr.json", std::ios::binary);
    if (!file)
        return true;
    const std::uintmax_t bytes = fs::file_size(path / "zarr.json", ignored);
    std::string text(static_cast<std::size_t>(std::min<std::uintmax_t>(bytes, kMaxMetadataBytes)), '\0');
    file.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(file.gcount()));
    return couldBeOurs(text);
}

#if TESSERA_WITH_IMPORT
InputListing listInput(const fs::path& given, const SourceChoice& choice) {
    const fs::path path = reached(given);
    requireExisting(path);
    InputListing listing;
    SourceOptions options;
    options.allowMissing = choice.allowMissing;
    options.spacingMm = choice.spacingMm;
    const Catalogue catalogue = lookThrough(path, options);
    for (const CatalogueRow& row : catalogue.rows) {
        listing.rows.push_back({row.series, row.modality, row.date, row.folder, row.what, row.problem,
                                row.number, row.slices, row.files, row.phases});
        if (!row.info)
            continue;
        listing.volumes.push_back({row.series > 0 ? "series " + std::to_string(row.series) : row.what,
                                   *row.info,
                                   row.path,
                                   row.series,
                                   {},
                                   {}});
        try {
            listing.volumes.back().levels = fileLevelsOf(catalogue, row, options);
        } catch (const InputError& error) {
            listing.volumes.back().levelsProblem = error.what();
        }
    }
    listing.table = tableOf(catalogue);
    listing.passedOver = countPassed(catalogue.scan.passed);
    for (const PassedFile& file : catalogue.scan.passed)
        listing.reasons.emplace_back(keyOf(file.reason));
    return listing;
}

namespace {

/// "one slice only, 2.5 mm thick"; of a DICOM file the others of its series may lie beside it.
std::string oneSliceText(const Catalogue& catalogue, const CatalogueRow& row) {
    std::error_code ignored;
    const bool isDicom = row.series > 0 && !row.isInFile && row.stack.empty();
    const bool isStated = !isDicom || row.info->acquisition.sliceThicknessMm > 0;
    const auto& axes = row.info->originalOrder.sourceAxis;
    const auto across = std::find(axes.begin(), axes.end(), 2) - axes.begin();
    return std::string("one slice only, ") + (isStated ? "" : "taken as ") +
           formatNumber(row.info->spacingMm()[static_cast<int>(across)]) + " mm thick" +
           (isDicom && !fs::is_directory(catalogue.path, ignored) ? "; name the folder for the whole series"
                                                                  : "");
}

/// Notes the choice among several volumes, and all skipped files.
void noteChoice(const Catalogue& catalogue, const CatalogueRow& row, const InputOptions& options,
                const CommonOptions& common) {
    const std::string label = row.series > 0 ? "series " + std::to_string(row.series) : row.what;
    if (options.largest && row.info) {
        const glm::dvec3 mm = row.info->spacingMm();
        const auto volumes = std::count_if(catalogue.rows.begin(), catalogue.rows.end(),
                                           [](const CatalogueRow& each) { return each.info.has_value(); });
        common.note("chose " + label + " of " + std::to_string(volumes) +
                    " found: " + formatExtent(row.info->extentVoxels) + " voxels of " + formatNumber(mm.x) +
                    " x " + formatNumber(mm.y) + " x " + formatNumber(mm.z) + " mm");
    }
    if (row.info && row.slices == 1 && !(options.allPhases && options.phase > 1)) // of all phases alike
        common.note(oneSliceText(catalogue, row));
    if (const int phase = phaseOf(row, SourceOptions{.series = options.series, .largest = options.largest});
        options.phase == 0 && phase > 0)
        common.note("took phase " + std::to_string(phase) + " of " + std::to_string(row.phases.size()) +
                    " (" + row.phases[static_cast<std::size_t>(phase) - 1] + "); --phase N chooses another");
    const std::string passed = passedOverText(catalogue, row);
    if (passed.empty())
        return;
    if (passesOverSomething(catalogue, row))
        common.note("took " + label + "; passed over: " + passed);
    else
        common.detail("passed over: " + passed);
}

} // namespace

std::unique_ptr<SlabSource> openInput(const fs::path& given, const InputOptions& asked,
                                      const fs::path& scratchFolder, const CommonOptions& common,
                                      ChoiceNote note) {
    const fs::path path = reached(given);
    requireExisting(path);
    if (looksLikeStore(path))
        throw badFile(path.string(), "files to import", "a Zarr group; a store is used as it is");
    common.progress->stage("looking through " + path.string());
    const InputOptions options = withFileLevel(path, asked, common, UnsaidLevel::finest);
    const SourceOptions source{
        options.series, options.resampleZ,    scratchFolder,     options.largest,
        options.phase,  options.allowMissing, options.spacingMm, options.fileLevel.value_or(0),
        options.fileBox};
    const Catalogue catalogue = lookThrough(path, source);
    const CatalogueRow& row = chooseRow(catalogue, source);
    auto opened = openRow(catalogue, row, source);
    if (note == ChoiceNote::given)
        noteChoice(catalogue, row, options, common);
    return opened;
}
#else
InputListing listInput(const fs::path& path, const SourceChoice&) {
    requireExisting(path);
    return {};
}

std::unique_ptr<SlabSource> openInput(const fs::path& path, const InputOptions&, const fs::path&,
                                      const CommonOptions&, ChoiceNote) {
    requireExisting(path);
    throw badFile(path.string(), "a store", "something else, and this program was built without importers");
}
#endif

void requireNoChoice(const fs::path& path, const InputOptions& options, const CommonOptions& common) {
    for (const auto& [chosen, option] : {std::pair{options.series > 0, "--series"},
                                         {options.phase > 0, "--phase"},
                                         {options.fileLevel.has_value(), "--file-level"},
                                         {options.fileBox.has_value(), "--file-box"}})
        if (chosen)
            throw badFile(path.string(), std::string("source files for ") + option + " to choose from",
                          "a store, which holds one volume");
    for (const auto& [asked, option] : {std::pair{options.largest, "--largest"},
                                        {options.resampleZ, "--resample-z"},
                                        {options.allowMissing, "--allow-missing"},
                                        {options.spacingMm.has_value(), "--spacing"}})
        if (asked)
            common.note(std::string(option) + " is for source files: " + path.string() +
                        " is a store, for which it has no effect");
}

void requireStorePath(const fs::path& given, bool force) {
    std::error_code ignored;
    const fs::path out = given.has_filename() ? given : given.parent_path(); // "x.zarr/" means x.zarr
    if (out.extension() != ".zarr")
        throw badFile(out.string(), "a store's name ending in .zarr", "another");
    if (!fs::exists(out, ignored))
        return;
    if (!isStore(out))
        throw badFile(out.string(), "a new name or a store to replace", "something else there");
    if (!force)
        throw badFile(out.string(), "a new name, or --force to replace", "a store of that name");
}

std::string parseUnit(const std::string& text) {
    if (text != "HU" && text != kSuvUnit)
        throw badFile("--unit", "HU or SUVbw", "\"" + text.substr(0, 40) + "\"");
    return text;
}

void noteImport(const ImportReport& report, const SlabSource& source, const fs::path& store,
                const MemoryBudget& ram, const CommonOptions& common) {
    common.progress->end();
    if (report.byOthers)
        return common.note(store.string() + " is there: another process has finished it");
    common.note("wrote " + store.string() + ": " + source.describe() + ", " + formatBytes(report.bytesOut) +
                " from " + formatBytes(report.bytesIn) + " in " + formatNumber(report.seconds, 3) + " s");
    for (const std::string& line : report.notes)
        common.note(line);
    for (const std::string& line : sayChanges(report.info))
        common.note(line);
    if (report.partsFound > 0)
        common.note(std::to_string(report.partsFound) + " of " + std::to_string(report.parts) +
                    " parts were there from an earlier or another run");
    common.detail("chunks: " + std::to_string(report.chunksWritten) + " written, " +
                  std::to_string(report.chunksFill) +
                  " left out (fill only); most RAM charged: " + formatBytes(ram.peakBytes()));
}

fs::path storeFor(const fs::path& given, const InputOptions& asked, MemoryBudget& ram,
                  const CommonOptions& common) {
    const fs::path path = reached(given);
    requireExisting(path);
    if (looksLikeStore(path)) { // the reader says what is wrong with a damaged one
        requireNoChoice(path, asked, common);
        if (const auto place = remotePlaceOf(path);
            place && !place->files->sizeOf(place->nameOf("stats/zarr.json")))
            common.note(path.string() + " has no statistics: all of the volume is fetched to make them");
        return path;
    }
    const InputOptions options = withFileLevel(path, asked, common, UnsaidLevel::fits);
    const MakeStore make = [&](const StoreToMake& wanted) {
        const fs::path& store = wanted.store;
        const auto source = openInput(path, options, store.parent_path(), common);
        common.detail("importing " + source->describe() + " to " + store.string());
        ImportOptions import;
        import.durable = wanted.durable;
        import.key = wanted.key;
        import.checkSource = wanted.checkSource;
        import.reopen = [&] {
            return openInput(path, options, store.parent_path(), common, ChoiceNote::omitted);
    };
    import.progress = common.progress.get();
    noteImport(importToStore(*source, store, ram, import), *source, store, ram, common);
};
return cachedStore(path, options.key(), common, make);
}

fs::path storeFor(const SceneVolume& volume, const InputOptions& named, MemoryBudget& ram,
                  const CommonOptions& common) {
    const bool isNamed = static_cast<const SourceChoice&>(named) != SourceChoice{};
    return storeFor(volume.path, isNamed ? named : InputOptions(volume.source), ram, common);
}

std::string sayAbsent(const VolumeInfo& info) {
    const double value = info.rescaleSlope * info.absentStored + info.rescaleIntercept;
    return std::to_string(info.nonFiniteVoxels) +
           " voxels without a number (NaN or infinite), stored as the lowest value, " +
           formatNumber(value, 6) + (info.unit.empty() ? "" : " " + info.unit);
}

std::string sayLoss(const VolumeInfo& info) {
    return info.lossyRatio > 0 ? "with loss, ratio " + formatNumber(info.lossyRatio) + " as the header says"
                               : "with loss";
}

std::string sayLabels(const VolumeInfo& info) {
    for (const std::string& remark : info.remarks)
        if (remark.rfind(kLabelMapRemark, 0) == 0)
            return remark;
    return "";
}

std::vector<std::string> sayChanges(const VolumeInfo& info) {
    std::vector<std::string> lines;
    if (info.lossy)
        lines.push_back("the source was compressed " + sayLoss(info));
    if (info.nonFiniteVoxels)
        lines.push_back(sayAbsent(info));
    if (info.clampedVoxels)
        lines.push_back(std::to_string(info.clampedVoxels) +
                        " voxels clamped to the range that can be stored");
    return lines;
}

namespace {
/// A number from 1, or "all".
void parsePhase(const std::string& text, InputOptions& input) {
    input.allPhases = text == "all";
    if (input.allPhases)
        return;
    if (const std::string problem = wholeNumberFrom(1)(text); !problem.empty())
        throw badFile("--phase", "a whole number from 1, or all", "\"" + text.substr(0, 40) + "\"");
    input.phase = std::stoi(text);
}
} // namespace

void addSelectionOptions(Command& command, InputOptions& input, PhaseWords words) {
    command
        .option("--series", input.series,
                "source files: number of the DICOM series, channel or grid, as listed")
        .check(wholeNumberFrom(1));
    command.flag("--largest", input.largest, "source files: the largest CT of a folder with several volumes");
    constexpr const char* kPhase = "source files: number of the phase or time, if a series or a file has "
                                   "several images at each position";
    if (words == PhaseWords::all)
        command.option(
            "--phase", [&input](const std::string& text) { parsePhase(text, input); },
            std::string(kPhase) + "; all: a film over them");
    else
        command.option("--phase", input.phase, kPhase).check(wholeNumberFrom(1));
    command.flag("--resample-z", input.resampleZ, "source files: interpolate uneven slices to even spacing");
    command.flag("--allow-missing", input.allowMissing,
                 "source files: leave out files that could be slices and cannot be read");
    addFilePartOptions(command, input);
}

namespace {
glm::dvec3 parseSpacing(const std::string& text) {
    constexpr double kLeastMm = 1e-6, kMostMm = 1e6;
    const std::optional<std::vector<double>> mm = lengthsOf(text, 3);
    if (!mm || !std::ranges::all_of(*mm, [](double one) { return one >= kLeastMm && one <= kMostMm; }))
        throw badFile("--spacing", "X,Y,Z: three lengths in mm, from 1e-6 to 1e6", "'" + text + "'");
    return {(*mm)[0], (*mm)[1], (*mm)[2]};
}
} // namespace

void addSpacingOption(Command& command, SourceChoice& choice) {
    command.option(
        "--spacing", [&choice](const std::string& text) { choice.spacingMm = parseSpacing(text); },
        "source files that do not say it: X,Y,Z, mm between voxels along the file's axes");
}

} // namespace tessera
