// viewer/cli/export.cpp: `tessera export SOURCE OUT`: a volume, or a box of it at a level, as a file that
// other programs read.
#include "bricking/analysis/body/body_box.h"
#include "bricking/export/label_value_source.h"
#include "bricking/export/volume_writer.h"
#include "bricking/labels/label_files.h" // readLabelTable
#include "bricking/labels/label_volume.h"
#include "bricking/store/store_files.h"
#include "bricking/store/store_reader.h"
#include "core/base/error.h"
#include "core/base/output_file.h"
#include "core/base/shown_text.h"
#include "core/scene/cuts.h"
#include "viewer/cli/commands.h"
#include "viewer/cli/input/label_input.h"
#include "viewer/cli/input/volume_input.h"
#include "viewer/cli/options/scene_options.h"       // cropBoxOf
#include "viewer/cli/render/scene_from_arguments.h" // inHu

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace tessera {
namespace {

struct ExportArguments {
    std::string in, out, format, box, crop, labels, unit, ram;
    int level = 0;
    bool compress = false, force = false, sameFrame = false;
    InputOptions input;
};

/// The box that the options name; nullopt: none, or the body's, which is found in the volume.
std::optional<CropBox> namedBox(const ExportArguments& arguments) {
    if (!arguments.box.empty())
        return cropBoxOf(arguments.box, "--crop-voxels", CropBox::Space::voxels);
    if (!arguments.crop.empty() && arguments.crop != ModeOptions::kBody)
        return cropBoxOf(arguments.crop, "--crop", CropBox::Space::patient, kCropForms);
    return std::nullopt;
}

PatientBox bodyOf(const ExportArguments& arguments, const StoreReader& store, MemoryBudget& ram,
                  const CommonOptions& common) {
    if (!inHu(store, arguments.unit, ram))
        throw badFile("--crop body", "values in HU, by which a body is found",
                      "values without a unit that do not look like HU; --unit HU takes them for HU");
    const BodyBox body = findBody(store, ram);
    common.note("--crop body: a body of " + formatNumber(body.litres, 3) + " l; " +
                formatNumber(body.litresLeftOut, 3) + " l of table and the like left out");
    return {body.low, body.high};
}

LevelBox boxOf(const ExportArguments& arguments, const std::optional<CropBox>& named,
               const StoreReader& store, MemoryBudget& ram, const CommonOptions& common) {
    const VolumeInfo& info = store.info();
    const int level = arguments.level;
    if (named && named->space == CropBox::Space::voxels)
        return levelBoxOf(info, level, named->low, named->high, "--crop-voxels");
    if (arguments.crop.empty())
        return wholeLevel(info, level);
    const PatientBox mm = named ? PatientBox{named->low, named->high} : bodyOf(arguments, store, ram, common);
    const PatientBox voxels = voxelBoxAround(info, mm);
    return levelBoxOf(info, level, voxels.low, voxels.high, "--crop");
}

/// Refuses what is there already, unless it may be replaced.
void checkTarget(const ExportArguments& arguments, const ExportFormat& format) {
    const std::filesystem::path out(arguments.out);
    if (format.writesFolder)
        return; // its writer does
    checkOutputFile(out, arguments.force ? Existing::isReplaced : Existing::isKept);
}

void tell(const ExportArguments& arguments, const BoxSource& box, const ExportReport& report, double seconds,
          const CommonOptions& common) {
    const VolumeInfo& info = box.info();
    const glm::dvec3 mm = info.spacingMm();
    common.progress->end();
    common.note("wrote " + arguments.out + ": " + formatExtent(info.extentVoxels) + " voxels of " +
                formatNumber(mm.x) + " x " + formatNumber(mm.y) + " x " + formatNumber(mm.z) + " mm, level " +
                std::to_string(box.box().level) + ", " + report.values + ", " + formatBytes(report.bytes) +
                " in " + formatNumber(seconds, 3) + " s");
    for (const std::string& note : report.notes)
        common.note(note);
    if (!info.orientationKnown)
        common.note(
            "the source does not say how the patient lies: axes are taken as left, posterior, superior");
}

/// The labels beside a scan, or a store that holds labels itself; null: neither.
struct ExportedLabels {
    std::unique_ptr<StoreReader> sets; // null: the store itself
    std::unique_ptr<LabelValueSource> numbers;
};

ExportedLabels labelsOf(const ExportArguments& arguments, const ExportFormat& format,
                        const StoreReader& store, MemoryBudget& ram, const CommonOptions& common) {
    ExportedLabels found;
    const bool areLabels = openIn(openFolder(store.path()), "sets/zarr.json", store.path()).has_value();
    if (arguments.labels.empty() && !areLabels) {
        if (arguments.sameFrame)
            throw badFile("--same-frame", "--labels, which it is for", "none");
        return found;
    }
    if (format.name == "ome-zarr")
        throw badFile(arguments.out, "a format without levels for labels (a store's levels are means)",
                      format.name);
    if (areLabels) {
        if (!arguments.labels.empty())
            throw badFile("--labels", "a scan for them", arguments.in + ", which holds labels itself");
    } else {
        Labels labels;
        labels.path = arguments.labels;
        labels.sameFrame = arguments.sameFrame;
        importLabelsFor(store.info(), labels, ram, common);
        found.sets = std::make_unique<StoreReader>(labels.store, ram);
        requireSameGrid(*found.sets, store.info());
    }
    const StoreReader& sets = found.sets ? *found.sets : store;
    const LabelTable table = readLabelTable(sets, ram);
    found.numbers = std::make_unique<LabelValueSource>(sets, table, sets.path().string());
    common.note("the values of " + std::to_string(table.labels.size()) +
                " labels, 0 where there is none; "
                "their names are left out");
    return found;
}

void runExport(const ExportArguments& arguments, const CommonOptions& common) {
    const auto start = std::chrono::steady_clock::now();
    if (!arguments.unit.empty() && arguments.unit != "HU")
        throw badFile("--unit", "HU", "\"" + arguments.unit.substr(0, 40) + "\"");
    const ExportFormat& format = exportFormatOf(arguments.format, arguments.out);
    if (arguments.compress && !format.compresses)
        throw badFile("--compress", "a format that can be compressed", format.name);
    checkTarget(arguments, format);
    if (format.name == "ome-zarr")
        requireStorePath(arguments.out, arguments.force);
    const std::optional<CropBox> named = namedBox(arguments);
    MemoryBudget ram("RAM", "--ram", budgetBytes(arguments.ram, "--ram", common));
    const StoreReader store(storeFor(arguments.in, arguments.input, ram, common), ram);
    const LevelBox part = boxOf(arguments, named, store, ram, common);
    const ExportedLabels labels = labelsOf(arguments, format, store, ram, common);
    BoxSource box(labels.numbers ? static_cast<const ChunkSource&>(*labels.numbers) : store, part, ram);
    common.detail("exporting " + box.describe() + " as " + format.name + " to " + arguments.out);
    const ExportReport report =
        format.write(box, {arguments.out, arguments.compress, arguments.force, ram, *common.progress});
    tell(arguments, box, report, secondsSince(start), common);
    common.detail("RAM: " + formatBytes(ram.peakBytes()) + " of " + formatBytes(ram.limitBytes()));
}

/// "nrrd (3D Slicer, ITK), ..."
std::string formatsText() {
    std::string text;
    for (const ExportFormat& format : exportFormats()) {
        text += (text.empty() ? "" : ", ") + format.name + " (";
        for (const std::string& ending : format.endings)
            text += ending + ", ";
        text += format.about + ")";
    }
    return text;
}

} // namespace

void addExportCommand(Command& program, const CommonOptions& common, Action& action) {
    Command command =
        program.command("export", "Write a volume, or a box of it, as a file for other programs");
    auto arguments = std::make_shared<ExportArguments>();
    command.option("SOURCE", arguments->in, "store, or source files").required();
    command.option("OUT", arguments->out, "file to write; its ending chooses the format").required();
    command.option("--format", arguments->format, formatsText() + " (default: by the ending of OUT)");
    command
        .option("--level", arguments->level,
                "level to write: 0 is the finest, each next one has half as "
                "many voxels along each axis")
        .showsDefault()
        .check(numberWithin(0, kLevelCount - 1,
                            "a level from 0 (finest) to " + std::to_string(kLevelCount - 1)));
    command.option("--crop-voxels", arguments->box,
                   std::string("only a box, in voxels of level 0 along the volume's axes: ") + kBoxForm +
                       ", whose second corner is the first voxel beyond");
    command
        .option("--crop", arguments->crop,
                std::string("only the voxels that touch a box along the patient's axes, mm: ") + kCropForms +
                    "; body: the patient's, without the table (CT)")
        .excludes("--crop-voxels");
    command.option("--labels", arguments->labels,
                   "labels of voxels to write in place of values, on the volume's lattice: files that render "
                   "takes. At coarser levels the label of most of 2 x 2 x 2 voxels");
    command.flag("--same-frame", arguments->sameFrame, "take --labels in any frame of reference");
    command.option("--unit", arguments->unit, "HU: the values are in HU, though the source cannot say so");
    command.flag("--compress", arguments->compress, "deflate the values, where the format allows it");
    command.flag("--force", arguments->force, "replace an existing file or store");
    command.option("--ram", arguments->ram, "budget, e.g. 512MiB (default: 1 GiB at most)");
    addSelectionOptions(command, arguments->input);
    addSpacingOption(command, arguments->input);
    command.footer(
        "Example:\n  tessera export abdomen.zarr liver.nrrd --crop-voxels 60,300,140,380,20,90 --compress");
    command.whenChosen(
        [arguments, &common, &action] { action = [arguments, &common] { runExport(*arguments, common); }; });
}

} // namespace tessera
