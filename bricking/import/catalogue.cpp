// bricking/import/catalogue.cpp: see catalogue.h.
#include "bricking/import/catalogue.h"

#include "bricking/import/dicom/could_belong.h"
#include "bricking/import/dicom/dicom_source.h"
#include "bricking/import/dicom/folder_walk.h"
#include "bricking/import/file_part.h"
#include "bricking/import/files/file_format.h"
#include "bricking/import/source/oriented_source.h"
#include "bricking/import/source/phase_choice.h"
#include "bricking/import/source/source_files.h"
#include "bricking/store/remote_files.h"
#include "core/base/address.h"
#include "core/base/error.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <set>
#include <system_error>

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr int kFewSlices = 2; // a scout has one or two; a volume has more

/// The folder of a file, relative to the catalogue's path; "" for that path itself.
std::string folderBelow(const fs::path& top, const fs::path& folder) {
    const std::string below = folder.lexically_relative(top).string();
    return below == "." || below.rfind("..", 0) == 0 ? "" : printableName(below);
}

/// The folder that holds all slices, also if each has a folder of its own.
std::string folderOf(const DicomSeries& series, const fs::path& top) {
    fs::path common = series.slices.front().file.parent_path();
    for (const DicomSlice& slice : series.slices)
        while (common != top && common.has_relative_path() &&
               slice.file.lexically_relative(common).string().rfind("..", 0) == 0)
            common = common.parent_path();
    return folderBelow(top, common);
}

/// Those of a file of several volumes or times; empty for others, and for a damaged one: opening it says why.
std::vector<FileVolume> volumesIn(const FileFormat& format, const fs::path& path) {
    try {
        return format.volumes ? format.volumes(path) : std::vector<FileVolume>{};
    } catch (const Error&) {
        return {};
    }
}

/// A file, or one of its volumes.
/// @param volume  null: it holds one
/// @param refused  gets the reason if it is refused without options
CatalogueRow rowOfFile(const FileFormat& format, const fs::path& path, const fs::path& top,
                       const FileVolume* volume, const SourceOptions& options,
                       std::optional<PassedFile>& refused) {
    CatalogueRow row;
    row.path = path;
    row.folder = folderBelow(top, path.parent_path());
    row.rank = CatalogueRank::volume;
    row.what = volume && !volume->name.empty() ? volume->name : printableName(path.filename());
    try {
        SourceOptions one = options;
        one.series = one.phase = 0;
        if (volume) {
            row.numbers = volume->numbers;
            row.phases = volume->times;
            one.series = row.numbers.front();
        } else if (format.phases) {
            row.phases = format.phases(path);
            one.phase = row.phases.empty() ? 0 : 1; // they have one lattice
        }
        if (!row.phases.empty())
            row.what += ", " + phasesText(row.phases, " for --phase");
        row.info = orientedInfo(format.open(path, one)->info());
        row.slices = alongSourceAxes(*row.info, row.info->extentVoxels).z;
        row.modality = row.info->acquisition.modality;
    } catch (const Error& error) {
        row.problem = withoutPath(error);
        const auto* file = dynamic_cast<const BadFile*>(&error);
        refused = PassedFile{path,
                             PassedReason::damaged,
                             file ? file->expected() : "a volume",
                             file ? file->found() : row.problem,
                             {},
                             true};
    }
    return row;
}

/// The volumes of a file that is named by itself.
void addRowsOf(const FileFormat& format, const fs::path& path, const SourceOptions& options,
               std::vector<CatalogueRow>& rows) {
    const std::vector<FileVolume> volumes = volumesIn(format, path);
    std::optional<PassedFile> refused; // the row has the reason
    if (volumes.empty())
        rows.push_back(rowOfFile(format, path, path.parent_path(), nullptr, options, refused));
    for (const FileVolume& volume : volumes) {
        CatalogueRow row = rowOfFile(format, path, path.parent_path(), &volume, options, refused);
        row.isInFile = volumes.size() > 1;
        row.series = row.isInFile ? row.numbers.front() : 0;
        rows.push_back(std::move(row));
    }
}

/// A volume whose slices are files of a folder. Refused, it keeps its rank: opening it says why.
CatalogueRow rowOfStack(const fs::path& folder, const std::vector<fs::path>& slices, const fs::path& top,
                        const SourceOptions& options) {
    CatalogueRow row;
    row.path = folder;
    row.folder = folderBelow(top, folder);
    row.rank = CatalogueRank::volume;
    row.slices = static_cast<int>(slices.size());
    row.what = "stack of pictures, " + printableName(slices.front().filename()) + " and others";
    row.stack = slices;
    try {
        row.info = orientedInfo(stackFormatOf(slices.front())->openStack(folder, slices, options)->info());
    } catch (const Error& error) {
        row.problem = error.what();
    }
    return row;
}

/// The description of a reconstruction, without any text that a person typed.
std::string reconstructionOf(const DicomSeries& series, const DicomListing& listing) {
    std::string text = series.isScout ? "scout (localizer)" : series.object;
    const auto add = [&](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
    const auto number = [](double value) {
        char shown[32];
        std::snprintf(shown, sizeof shown, "%.4g", value);
        return std::string(shown);
    };
    const Acquisition& a = series.acquisition;
    if (!series.part.empty())
        add(series.part);
    if (!series.derivation.empty())
        add(series.derivation);
    if (!a.kernel.empty())
        add("kernel " + a.kernel);
    if (a.sliceThicknessMm > 0)
        add(number(a.sliceThicknessMm) + " mm thick");
    if (a.tubeVoltageKv > 0)
        add(number(a.tubeVoltageKv) + " kV");
    if (std::abs(listing.tiltDegrees) > 0.05)
        add("tilt " + number(listing.tiltDegrees) + " degrees");
    if (!listing.phases.empty())
        add(phasesText(listing.phases, " for --phase"));
    if (listing.duplicates > 0)
        add(std::to_string(listing.duplicates) +
            (listing.duplicates == 1 ? " duplicate dropped" : " duplicates dropped"));
    return text;
}

CatalogueRow rowOfSeries(const DicomScan& scan, std::size_t index, const fs::path& path, bool allowMissing) {
    const DicomSeries& series = scan.series[index];
    const DicomListing listing = listDicom(scan, index, allowMissing);
    CatalogueRow row;
    row.series = static_cast<int>(index) + 1;
    row.path = path;
    row.number = series.number;
    row.date = series.date;
    row.folder = folderOf(series, path);
    row.modality = series.acquisition.modality;
    row.slices = listing.slices;
    row.what = reconstructionOf(series, listing);
    row.problem = listing.problem;
    row.phases = listing.phases;
    row.duplicates = listing.duplicates;
    if (listing.info)
        row.info = orientedInfo(*listing.info);
    if (listing.missing > 0) {
        const std::string count =
            std::to_string(listing.missing) + (listing.missing == 1 ? " file" : " files");
        const std::string missing = allowMissing
                                        ? count + " left out that could be slices"
                                        : "incomplete: " + count +
                                              " could be slices and cannot be read (--allow-missing leaves " +
                                              (listing.missing == 1 ? "it" : "them") + " out)";
        row.problem += (row.problem.empty() ? "" : "; ") + missing;
    }
    std::set<std::array<double, 3>> places;
    for (const DicomSlice& slice : series.slices)
        if (slice.positionMm)
            places.insert({slice.positionMm->x, slice.positionMm->y, slice.positionMm->z});
    row.rank = series.isScout                                          ? CatalogueRank::scout
               : places.size() <= kFewSlices || !series.object.empty() ? CatalogueRank::slice
                                                                       : CatalogueRank::volume;
    return row;
}

InputError withTable(const InputError& error, const Catalogue& catalogue) {
    return InputError(std::string(error.what()) + "\n" + tableOf(catalogue));
}

/// ": series 1, 2 and 7": the competing rows of the table.
std::string whichSeries(const std::vector<const CatalogueRow*>& rows) {
    constexpr std::size_t kMostNumbers = 12;
    std::string text;
    for (std::size_t i = 0; i < std::min(rows.size(), kMostNumbers); ++i) {
        if (rows[i]->series == 0)
            return "";
        text += (i == 0 ? ": series " : ", ") + std::to_string(rows[i]->series);
    }
    return text + (rows.size() > kMostNumbers ? ", ..." : "");
}

/// Throws for a path without volumes, with its content.
[[noreturn]] void refuseNothing(const Catalogue& catalogue) {
    const std::string where = printableName(catalogue.path);
    const std::vector<PassedFile>& passed = catalogue.scan.passed;
    const auto damaged = std::find_if(passed.begin(), passed.end(), [](const PassedFile& file) {
        return file.reason == PassedReason::damaged;
    });
    if (damaged != passed.end())
        throw badFile(printableName(damaged->path), damaged->expected, damaged->found);
    std::error_code none;
    const ForeignFormat itself = foreignFormatOf(catalogue.path);
    const std::string expected = fs::is_directory(catalogue.path, none)
                                     ? withFormats("DICOM slices", &FileFormat::inFolders)
                                     : withFormats("a DICOM file or folder", &FileFormat::named);
    if (itself.known()) {
        const fs::path metadata = catalogue.path / "zarr.json";
        throw badFile(fs::exists(metadata, none) ? printableName(metadata) : where, expected, itself.text());
    }
    std::vector<fs::path> files;
    for (const PassedFile& file : passed)
        if (file.reason == PassedReason::notDicom || file.reason == PassedReason::notSlice ||
            file.reason == PassedReason::zarr)
            files.push_back(file.path);
    const std::string counted = countPassed(passed), foreign = countForeign(files);
    const InputError error = badFile(where, expected,
                                     foreign.empty()   ? (counted.empty() ? "no files" : counted)
                                     : counted.empty() ? foreign
                                                       : foreign + "; in all " + counted);
    throw catalogue.rows.empty() ? error : withTable(error, catalogue);
}

void refuseSpacing(const fs::path& path) {
    throw badFile(printableName(path), "a file that does not say its spacing, for --spacing",
                  "one that does");
}

std::unique_ptr<SlabSource> fileOf(const Catalogue& catalogue, const CatalogueRow& row,
                                   const SourceOptions& options) {
    const fs::path& path = row.path;
    if (!row.stack.empty())
        return stackFormatOf(row.stack.front())->openStack(path, row.stack, options);
    const FileFormat* format = fileFormatOf(path);
    if (!format)
        refuseNothing(catalogue);
    if (options.spacingMm && !format->takesSpacing)
        refuseSpacing(path);
    SourceOptions one = options;
    one.series = 0;
    if (!row.numbers.empty()) {
        const int phase = phaseOf(row, options);
        one.series = row.numbers[chosenPhase(row.phases, phase, printableName(path))];
        one.phase = 0; // the number says it
    }
    return format->open(path, one);
}

/// True for a file that is a volume once its spacing is given.
bool lacksSpacing(const CatalogueRow& row, const SourceOptions& options) {
    const FileFormat* const format = fileFormatOf(row.path);
    if (row.info || options.spacingMm || !format || !format->takesSpacing)
        return false;
    SourceOptions given = options;
    given.spacingMm = glm::dvec3(1);
    given.series = row.numbers.empty() ? 0 : row.numbers.front();
    try {
        return format->open(row.path, given) != nullptr;
    } catch (const Error&) {
        return false;
    }
}

/// Pictures of a folder are a stack where nothing else is a volume: beside others they are illustrations.
void takeStacks(const std::vector<fs::path>& files, Catalogue& catalogue, const SourceOptions& options) {
    std::map<fs::path, std::vector<fs::path>> folders;
    for (const fs::path& file : files)
        if (stackFormatOf(file) && file.filename().string().front() != '.')
            folders[file.parent_path()].push_back(file);
    std::set<fs::path> used;
    for (const auto& [folder, slices] : folders) {
        const auto hasRow = [&](const fs::path& slice) { // refused as a volume by itself
            return std::any_of(catalogue.rows.begin(), catalogue.rows.end(),
                               [&](const CatalogueRow& row) { return row.path == slice; });
        };
        if (std::all_of(slices.begin(), slices.end(), hasRow))
            continue;
        if (slices.size() == 1 && !fileFormatOf(slices.front()))
            continue; // a picture
        catalogue.rows.push_back(rowOfStack(folder, slices, catalogue.path, options));
        used.insert(slices.begin(), slices.end());
    }
    std::erase_if(catalogue.scan.passed, [&](const PassedFile& file) { return used.contains(file.path); });
}

/// What a server says that lists no names.
std::string forbiddenAt(const fs::path& address) {
    const auto place = remotePlaceOf(address);
    const std::string why = place ? place->files->whyNone() : "";
    return why.empty() ? "" : " (" + why + ")";
}

} // namespace

Catalogue lookThrough(const fs::path& path, const SourceOptions& given) {
    const SourceOptions options = finestOf(given);
    std::error_code error;
    if (!isAddress(path) && !fs::exists(path, error))
        throw badFile(printableName(path), "a file or a folder", "nothing there");
    Catalogue catalogue;
    catalogue.path = path;
    if (const FileFormat* format = fileFormatOf(path)) {
        addRowsOf(*format, path, options, catalogue.rows);
        return catalogue;
    }
    if (isAddress(path))
        throw badFile(printableName(path), "a store, an OME-Zarr or an array of Zarr at the address",
                      "no metadata of them there" + forbiddenAt(path));
    if (!fs::is_directory(path, error)) {
        catalogue.scan = scanDicom({path});
    } else if (foreignFormatOf(path).known()) {
        return catalogue;
    } else {
        FolderFiles found = walkFolder(path);
        std::set<fs::path> used; // single-file volumes and their data
        for (const fs::path& file : found.files) {
            const FileFormat* format = fileFormatOf(file);
            if (used.contains(file) || used.contains(file.lexically_normal()))
                continue; // a part of one before
            if (!format || !(format->isMeant ? format->isMeant(file) : !isNeverASlice(file)))
                continue;
            used.insert(file);
            if (format->parts)
                for (const fs::path& part : format->parts(file))
                    used.insert(part.lexically_normal());
            std::optional<PassedFile> refused;
            const std::vector<FileVolume> volumes = volumesIn(*format, file);
            CatalogueRow row = rowOfFile(*format, file, path, volumes.size() == 1 ? volumes.data() : nullptr,
                                         options, refused);
            if (refused) {
                row.rank = CatalogueRank::none;
                row.files = 1;
                found.passed.push_back(std::move(*refused));
            }
            catalogue.rows.push_back(std::move(row));
        }
        std::vector<fs::path> others;
        for (const fs::path& file : found.files) {
            if (used.contains(file) || used.contains(file.lexically_normal()))
                continue;
            if (isNeverASlice(file) && !(hasSlicesMark(file) && !isNeverOpened(file)))
                found.passed.push_back({file, PassedReason::notSlice});
            else
                others.push_back(file);
        }
        catalogue.scan = scanDicom(others);
        catalogue.scan.passed.insert(catalogue.scan.passed.end(), found.passed.begin(), found.passed.end());
        const bool hasVolume =
            std::any_of(catalogue.rows.begin(), catalogue.rows.end(),
                        [&](const CatalogueRow& row) { return row.info || lacksSpacing(row, options); });
        if (catalogue.scan.series.empty() && !hasVolume)
            takeStacks(found.files, catalogue, options);
    }
    std::vector<CatalogueRow> rows;
    for (std::size_t index = 0; index < catalogue.scan.series.size(); ++index)
        rows.push_back(rowOfSeries(catalogue.scan, index, path, options.allowMissing));
    for (CatalogueRow& row : catalogue.rows)
        rows.push_back(std::move(row));
    for (const DicomOther& other : catalogue.scan.others) {
        CatalogueRow row;
        row.modality = other.modality;
        row.files = other.files;
        row.what = other.what;
        rows.push_back(std::move(row));
    }
    catalogue.rows = std::move(rows);
    return catalogue;
}

std::vector<fs::path> namedFilesOf(const fs::path& path) {
    std::error_code none;
    std::vector<fs::path> named;
    const bool isFolder = fs::is_directory(path, none);
    if (isFolder && fileFormatOf(path))
        return named; // its files are its own
    for (const fs::path& file : isFolder ? walkFolder(path).files : std::vector<fs::path>{path})
        if (const FileFormat* format = fileFormatOf(file); format && format->parts)
            for (fs::path& part : format->parts(file))
                named.push_back(std::move(part));
    return named;
}

namespace {

/// The place of --series among the numbers of a volume's times; nullopt: it means no time of it.
std::optional<std::size_t> timeBySeries(const CatalogueRow& row, const SourceOptions& options) {
    const auto at = std::ranges::find(row.numbers, options.series);
    if (options.phase != 0 || at == row.numbers.end())
        return std::nullopt;
    return static_cast<std::size_t>(at - row.numbers.begin());
}

} // namespace

int phaseOf(const CatalogueRow& row, const SourceOptions& options) {
    if (options.phase != 0 || row.phases.empty() || row.numbers.empty())
        return options.phase;
    const std::optional<std::size_t> time = timeBySeries(row, options);
    return time ? static_cast<int>(*time) + 1 : options.largest ? 1 : 0;
}

const CatalogueRow& chooseRow(const Catalogue& catalogue, const SourceOptions& options) {
    const std::string where = printableName(catalogue.path);
    const auto count =
        static_cast<int>(std::count_if(catalogue.rows.begin(), catalogue.rows.end(),
                                       [](const CatalogueRow& row) { return row.series > 0; }));
    if (options.series != 0) {
        for (const CatalogueRow& row : catalogue.rows)
            if (row.series == options.series)
                return row;
        for (const CatalogueRow& row : catalogue.rows) // of a file that is named by itself
            if (row.path == catalogue.path && timeBySeries(row, options))
                return row;
        std::error_code none;
        const bool isFile = !fs::is_directory(catalogue.path, none) || fileFormatOf(catalogue.path);
        if (count == 0 && !catalogue.rows.empty() && isFile) { // opening it says what is wrong with it
            if (options.series != 1 && catalogue.rows.front().info)
                throw badFile(where, "one volume: --series 1 or none", std::to_string(options.series));
            return catalogue.rows.front();
        }
        if (count == 0)
            refuseNothing(catalogue);
        int highest = 0;
        for (const CatalogueRow& row : catalogue.rows)
            highest = std::max(highest, row.series);
        throw withTable(badFile(where,
                                (highest == count ? "--series between 1 and " + std::to_string(count)
                                                  : "a number of the table for --series"),
                                std::to_string(options.series)),
                        catalogue);
    }
    std::vector<const CatalogueRow*> rows;
    for (const CatalogueRank rank : {CatalogueRank::volume, CatalogueRank::slice, CatalogueRank::scout}) {
        for (const CatalogueRow& row : catalogue.rows)
            if (row.rank == rank)
                rows.push_back(&row);
        if (!rows.empty())
            break;
    }
    if (rows.empty())
        refuseNothing(catalogue);
    if (rows.front()->rank == CatalogueRank::scout)
        throw withTable(badFile(where, "slices of a volume",
                                "a scout (localizer), a projection without depth, which is no volume; name "
                                "the folder with the sections, or take it nevertheless with --series " +
                                    std::to_string(rows.front()->series)),
                        catalogue);
    const auto isCt = [](const CatalogueRow* row) { return row->modality == "CT"; };
    if (options.largest) {
        std::vector<const CatalogueRow*> sized;
        for (const CatalogueRow* row : rows)
            if (row->info)
                sized.push_back(row);
        if (sized.empty())
            return *rows.front();
        return **std::max_element(sized.begin(), sized.end(),
                                  [&](const CatalogueRow* a, const CatalogueRow* b) {
                                      const auto rank = [&](const CatalogueRow* row) {
                                          return std::pair(isCt(row), row->info->voxelCount());
                                      };
                                      return rank(a) < rank(b);
                                  });
    }
    if (rows.size() == 1)
        return *rows.front();
    const auto scans = std::count_if(rows.begin(), rows.end(), isCt);
    if (scans == 1)
        return **std::find_if(rows.begin(), rows.end(), isCt);
    const bool series =
        std::any_of(rows.begin(), rows.end(), [](const auto* row) { return row->series > 0; });
    throw withTable(badFile(where,
                            series ? "one volume, or a choice with --series N or --largest"
                                   : "one volume, or the name of one file, or --largest",
                            std::to_string(rows.size()) + " volumes" + whichSeries(rows)),
                    catalogue);
}

std::unique_ptr<SlabSource> openRow(const Catalogue& catalogue, const CatalogueRow& row,
                                    const SourceOptions& options) {
    const bool isDicom = row.series > 0 && !row.isInFile;
    if (!isDicom && options.phase != 0 && row.info && row.phases.empty())
        throw badFile(printableName(row.path), "several phases for --phase to choose from", "one volume");
    if (isDicom && options.spacingMm)
        refuseSpacing(row.path);
    const auto open = [&](const SourceOptions& one) {
        return isDicom ? openDicom(catalogue.scan, static_cast<std::size_t>(row.series - 1), one,
                                   printableName(row.path))
                       : fileOf(catalogue, row, one);
    };
    return orientToLps(openFilePart(open, options, printableName(row.path)), options.scratchFolder);
}

bool mayHaveLevels(const fs::path& path) {
    const FileFormat* const format = fileFormatOf(path);
    return format && format->hasLevels;
}

std::vector<VolumeInfo> fileLevelsOf(const Catalogue& catalogue, const CatalogueRow& row,
                                     const SourceOptions& options) {
    std::vector<VolumeInfo> levels;
    SourceOptions one = finestOf(options);
    if (!row.phases.empty() && phaseOf(row, one) == 0)
        one.phase = 1; // they have one lattice
    if (row.info && row.stack.empty() && mayHaveLevels(row.path))
        for (const VolumeInfo& level : fileOf(catalogue, row, one)->fileLevels())
            levels.push_back(orientedInfo(level));
    return levels.size() > 1 ? levels : std::vector<VolumeInfo>{};
}

} // namespace tessera
