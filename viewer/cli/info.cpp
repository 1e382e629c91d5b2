// viewer/cli/info.cpp: `tessera info X`: what a store or source files hold. Only what the whitelist of
// core/base/volume.h lets through can be shown, so no identifier can.
#include "bricking/import/source/file_levels.h"
#include "bricking/import/source/format_endings.h"
#include "bricking/statistics/statistics.h"
#include "bricking/store/store_reader.h"
#include "core/base/address.h"
#include "core/base/error.h"
#include "core/base/shown_text.h"
#include "core/base/volume.h"
#include "viewer/cli/commands.h"
#include "viewer/cli/info_picture.h"
#include "viewer/cli/input/file_level.h"
#include "viewer/cli/input/remote_input.h"
#include "viewer/cli/input/volume_input.h"
#include "viewer/cli/manifest/manifest.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct InfoArguments {
    std::string in, ram;
    bool asJson = false;
    InputOptions choice;
};

json asJson(const glm::dvec3& v) {
    return {v.x, v.y, v.z};
}

json volumeJson(const VolumeInfo& info) {
    const glm::dvec3 mm = info.spacingMm();
    const PatientBox place = patientBoxOf(info);
    json affine = json::array(); // rows
    for (int row = 0; row < 4; ++row) {
        affine.push_back(json::array());
        for (int column = 0; column < 4; ++column)
            affine.back().push_back(info.patientFromVoxel[column][row]);
    }
    return {{"extentVoxels", {info.extentVoxels.x, info.extentVoxels.y, info.extentVoxels.z}},
            {"spacingMm", {mm.x, mm.y, mm.z}},
            {"type", name(info.type)},
            {"unit", info.unit},
            {"rescaleSlope", info.rescaleSlope},
            {"rescaleIntercept", info.rescaleIntercept},
            {"fillStored", info.fillStored},
            {"patientFromVoxel", affine},
            {"originalOrder",
             {{"sourceAxis", info.originalOrder.sourceAxis}, {"flipped", info.originalOrder.flipped}}},
            {"orientationKnown", info.orientationKnown},
            {"frameOfReference", info.frameOfReference},
            {"acquisition",
             {{"modality", info.acquisition.modality},
              {"kernel", info.acquisition.kernel},
              {"tubeVoltageKv", info.acquisition.tubeVoltageKv},
              {"sliceThicknessMm", info.acquisition.sliceThicknessMm}}},
            {"lossy", info.lossy},
            {"lossyRatio", info.lossyRatio},
            {"fieldOfViewMm",
             {mm.x * info.extentVoxels.x, mm.y * info.extentVoxels.y, mm.z * info.extentVoxels.z}},
            {"gantryTiltDegrees", gantryTiltDegrees(info)},
            {"nonFiniteVoxels", info.nonFiniteVoxels},
            {"absentStored", info.absentStored},
            {"clampedVoxels", info.clampedVoxels},
            {"placeMm", {{"from", asJson(place.low)}, {"to", asJson(place.high)}}},
            {"suvPerValue", info.suvPerValue},
            {"remarks", info.remarks}};
}

std::string orderText(const AxisOrder& order) {
    std::string text;
    for (std::size_t axis = 0; axis < 3; ++axis)
        text += std::string(axis ? ", " : "") + "xyz"[axis] + " from source axis " +
                std::to_string(order.sourceAxis[axis]) + (order.flipped[axis] ? " reversed" : "");
    return text;
}

json levelsJson(const std::vector<VolumeInfo>& levels) {
    json all = json::array();
    for (const VolumeInfo& level : levels)
        all.push_back({{"extentVoxels", {level.extentVoxels.x, level.extentVoxels.y, level.extentVoxels.z}},
                       {"spacingMm", asJson(level.spacingMm())},
                       {"decodedBytes", decodedBytes(level)}});
    return all;
}

/// Of a file: the levels for --file-level.
void printLevels(const ListedVolume& volume) {
    for (std::size_t n = 0; n < volume.levels.size(); ++n) {
        const VolumeInfo& level = volume.levels[n];
        const glm::dvec3 mm = level.spacingMm();
        printLine(("level " + std::to_string(n)).c_str(),
                  formatExtent(level.extentVoxels) + " voxels of " + formatNumber(mm.x) + " x " +
                      formatNumber(mm.y) + " x " + formatNumber(mm.z) + " mm, " +
                      formatBytes(decodedBytes(level)) + " decoded");
    }
    if (!volume.levelsProblem.empty())
        printLine("levels", "not known: " + volume.levelsProblem);
}

constexpr double kLeastTilt = 0.05; // degrees; below it is the rounding of headers

/// In the numbers that --slice, --crop, --from and cameras take.
void printPlace(const VolumeInfo& info) {
    const PatientBox box = patientBoxOf(info);
    const auto range = [&](int axis) {
        return std::string(1, "xyz"[axis]) + " " + formatNumber(box.low[axis], 6) + " to " +
               formatNumber(box.high[axis], 6);
    };
    printLine("place", range(0) + ", " + range(1) + ", " + range(2) + " mm (to the left, back and head" +
                           (info.orientationKnown ? ")" : ", if the source's orientation is right)"));
}

void printVolume(const VolumeInfo& info) {
    const glm::dvec3 mm = info.spacingMm();
    printLine("size", formatExtent(info.extentVoxels) + " voxels of " + formatNumber(mm.x) + " x " +
                          formatNumber(mm.y) + " x " + formatNumber(mm.z) + " mm");
    printLine("field of view", formatNumber(mm.x * info.extentVoxels.x) + " x " +
                                   formatNumber(mm.y * info.extentVoxels.y) + " x " +
                                   formatNumber(mm.z * info.extentVoxels.z) + " mm");
    printPlace(info);
    if (const double tilt = gantryTiltDegrees(info); std::abs(tilt) > kLeastTilt)
        printLine("gantry tilt", formatNumber(tilt) + " degrees (anterior edge of the slices towards the " +
                                     (tilt > 0 ? "head)" : "feet)"));
    printLine("type", std::string(name(info.type)) + ", value = " + formatNumber(info.rescaleSlope, 6) +
                          " * stored + " + formatNumber(info.rescaleIntercept, 6) +
                          (info.unit.empty() ? ", unit unknown" : " " + info.unit));
    if (info.suvPerValue > 0 && info.unit != kSuvUnit)
        printLine("SUV", "SUVbw = " + formatNumber(info.suvPerValue, 6) +
                             " * value; import with --unit SUVbw stores it");
    const Acquisition& a = info.acquisition;
    std::string text = a.modality.empty() ? "modality unknown" : a.modality;
    if (!a.kernel.empty())
        text += ", kernel " + a.kernel;
    if (a.tubeVoltageKv > 0)
        text += ", " + formatNumber(a.tubeVoltageKv) + " kV";
    if (a.sliceThicknessMm > 0)
        text += ", slices " + formatNumber(a.sliceThicknessMm) + " mm thick";
    printLine("acquisition", text);
    printLine("order", orderText(info.originalOrder));
    if (!info.orientationKnown)
        printLine("orientation", "not stated by the source: left may be right");
    if (!info.frameOfReference.empty())
        printLine("frame",
                  info.frameOfReference + " (FrameOfReferenceUID: objects of one frame lie together)");
    if (info.nonFiniteVoxels)
        printLine("absent", sayAbsent(info));
    if (info.lossy)
        printLine("compression", sayLoss(info));
    if (info.clampedVoxels)
        printLine("clamped", std::to_string(info.clampedVoxels) + " voxels");
    for (const std::string& remark : info.remarks)
        printLine("remark", remark);
}

std::uintmax_t bytesOnDisk(const fs::path& folder) {
    std::uintmax_t bytes = 0;
    std::error_code ignored;
    for (const auto& entry : fs::recursive_directory_iterator(folder, ignored))
        if (entry.is_regular_file(ignored))
            bytes += entry.file_size(ignored);
    return bytes;
}

void infoStore(const InfoArguments& arguments, const CommonOptions& common) {
    MemoryBudget ram("RAM", "--ram", budgetBytes(arguments.ram, "--ram", common));
    const StoreReader store(reached(arguments.in), ram);
    const Statistics statistics = loadStatistics(store, ram, 0);
    const VolumeInfo& info = store.info();
    const auto physical = [&](float stored) {
        return info.rescaleSlope * static_cast<double>(stored) + info.rescaleIntercept;
    };
    const double a = physical(statistics.lowest), b = physical(statistics.highest);
    const std::uintmax_t bytes = bytesOnDisk(arguments.in);
    if (arguments.asJson) {
        json report = volumeJson(info);
        report["kind"] = "store";
        report["lowest"] = std::min(a, b);
        report["highest"] = std::max(a, b);
        if (!isAddress(arguments.in))
            report["bytesOnDisk"] = bytes;
        report["contentHash"] = store.contentHash();
        if (info.filePart)
            report["filePart"] = filePartJson(*info.filePart);
        report["levels"] = json::array();
        for (int level = 0; level < kLevelCount; ++level) {
            const glm::ivec3 n = levelExtent(info.extentVoxels, level);
            report["levels"].push_back({n.x, n.y, n.z});
        }
        std::printf("%s\n", report.dump(2, ' ', true, json::error_handler_t::replace).c_str());
        return;
    }
    printLine("store", store.path().string());
    printVolume(info);
    if (info.filePart)
        printLine("part", sayFilePart(*info.filePart));
    printLine("values", formatNumber(std::min(a, b), 6) + " to " + formatNumber(std::max(a, b), 6) +
                            (info.unit.empty() ? "" : " " + info.unit));
    printLine("levels", std::to_string(kLevelCount) + ", the coarsest " +
                            formatExtent(levelExtent(info.extentVoxels, kLevelCount - 1)));
    if (!isAddress(arguments.in))
        printLine("on disk", formatBytes(static_cast<std::size_t>(bytes)));
    printLine("content", store.contentHash());
}

json rowJson(const ListedRow& row) {
    json out = {{"modality", row.modality}, {"what", row.what}, {"problem", row.problem}};
    if (row.series > 0)
        out["series"] = row.series;
    if (row.number)
        out["seriesNumber"] = *row.number;
    if (!row.date.empty())
        out["date"] = row.date;
    if (!row.folder.empty())
        out["folder"] = row.folder;
    if (row.files > 0)
        out["files"] = row.files;
    else
        out["slices"] = row.slices;
    if (!row.phases.empty())
        out["phases"] = row.phases;
    return out;
}

void infoSource(const InfoArguments& arguments, const CommonOptions& common) {
    const InputListing listing = listInput(arguments.in, arguments.choice);
    const std::vector<ListedVolume>& listed = listing.volumes;
    std::error_code ignored;
    const bool isFolder = fs::is_directory(arguments.in, ignored);
    const auto printTable = [&] {
        std::printf("%s\n", listing.table.c_str());
        if (!listing.passedOver.empty())
            printLine("passed over", listing.passedOver);
        std::fflush(stdout); // before what goes to stderr
    };
    // For a path that is no volume the importer explains.
    if (listed.empty()) {
        if (isFolder && !listing.rows.empty() && !arguments.asJson)
            printTable();
        static_cast<void>(openInput(arguments.in, arguments.choice, {}, common));
    }
    if (arguments.asJson) {
        json report = {{"kind", "source"}, {"volumes", json::array()}, {"series", json::array()}};
        std::vector<ListedVolume> bySize = listed; // largest first
        std::stable_sort(bySize.begin(), bySize.end(), [](const ListedVolume& a, const ListedVolume& b) {
            return a.info.voxelCount() > b.info.voxelCount();
        });
        for (const ListedVolume& volume : bySize) {
            report["volumes"].push_back(volumeJson(volume.info));
            report["volumes"].back()["label"] = volume.label;
            report["volumes"].back()["series"] = volume.series;
            if (!volume.levels.empty())
                report["volumes"].back()["levels"] = levelsJson(volume.levels);
            if (!volume.levelsProblem.empty())
                report["volumes"].back()["levelsProblem"] = volume.levelsProblem;
        }
        for (const ListedRow& row : listing.rows)
            report["series"].push_back(rowJson(row));
        report["passedOver"] = json::object();
        for (const std::string& reason : listing.reasons)
            report["passedOver"][reason] = report["passedOver"].value(reason, 0) + 1;
        std::printf("%s\n", report.dump(2, ' ', true, json::error_handler_t::replace).c_str());
        return;
    }
    if (isFolder || listing.rows.size() > 1) { // a file of several volumes
        printTable();
        std::printf("\n");
    }
    for (std::size_t i = 0; i < listed.size(); ++i) {
        if (i)
            std::printf("\n");
        printLine("source", listed[i].label);
        printVolume(listed[i].info);
        printLevels(listed[i]);
    }
    common.note("value ranges are known after `tessera import`");
}

/// True for a file with the name of a picture that is a volume, or would be one with a spacing.
bool isStackOfPages(const InfoArguments& arguments) {
    const auto isEnding = [&](const std::string& ending) { return arguments.in.ends_with(ending); };
    if (std::ranges::none_of(volumeFileEndings(), isEnding))
        return false;
    SourceChoice choice = arguments.choice;
    choice.spacingMm = choice.spacingMm.value_or(glm::dvec3(1));
    return !listInput(arguments.in, choice).volumes.empty();
}

void runInfo(const InfoArguments& arguments, const CommonOptions& common) {
    if (isPictureName(arguments.in) && !isStackOfPages(arguments))
        infoPicture(arguments.in, arguments.asJson);
    else if (looksLikeStore(arguments.in))
        infoStore(arguments, common);
    else
        infoSource(arguments, common);
}

} // namespace

void addInfoCommand(Command& program, const CommonOptions& common, Action& action) {
    Command command = program.command(
        "info", "Describe a store or source files, or the settings and the error of a picture");
    auto arguments = std::make_shared<InfoArguments>();
    command.option("X", arguments->in, "store, DICOM file or folder, .nii, picture, ...").required();
    command.flag("--json", arguments->asJson, "as JSON");
    command.flag("--allow-missing", arguments->choice.allowMissing,
                 "source files: leave out files that could be slices and cannot be read");
    addSpacingOption(command, arguments->choice);
    command.option("--ram", arguments->ram, "budget, e.g. 512MiB (default: 1 GiB at most)");
    command.footer("Example:\n  tessera info abdomen.zarr --json");
    command.whenChosen(
        [arguments, &common, &action] { action = [arguments, &common] { runInfo(*arguments, common); }; });
}

} // namespace tessera
