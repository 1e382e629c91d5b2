// viewer/cli/import.cpp: `tessera import IN OUT.zarr`: any readable input to a store, streaming.
#include "bricking/export/preview.h"
#include "bricking/import/importer.h"
#include "bricking/import/source/format_endings.h"
#include "bricking/store/store_reader.h"
#include "bricking/store/work_folder.h"
#include "core/base/error.h"
#include "core/base/names.h"
#include "viewer/cli/commands.h"
#include "viewer/cli/input/file_level.h"
#include "viewer/cli/input/source_facts.h"
#include "viewer/cli/input/volume_input.h"

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

namespace tessera {
namespace {

struct ImportArguments {
    std::string in, out, ram;
    InputOptions input;
    std::string unit, codec, preview;
    bool force = false, share = false;
};

/// After an import that was ended: what the next one finds.
void notePartsLeft(const std::filesystem::path& out, const std::string& key, const CommonOptions& common) {
    const int parts = WorkFolder::partsOf(out, key);
    if (parts == 1)
        common.note("a finished part of the import stays beside " + out.string() +
                    ": the same command goes on with it");
    else if (parts > 1)
        common.note(std::to_string(parts) + " finished parts of the import stay beside " + out.string() +
                    ": the same command goes on with them");
}

void runImport(const ImportArguments& arguments, const CommonOptions& common) {
    ImportOptions options;
    if (!arguments.unit.empty())
        options.unit = parseUnit(arguments.unit);
    if (!arguments.codec.empty())
        options.codec = static_cast<Codec>(indexOfName(arguments.codec, losslessCodecNames(), "--codec"));
    std::optional<Codec> preview;
    if (!arguments.preview.empty())
        preview = parseName<Codec>("dct-" + arguments.preview, "--preview");
    MemoryBudget ram("RAM", "--ram", budgetBytes(arguments.ram, "--ram", common));
    const std::filesystem::path out(arguments.out);
    const auto makePreview = [&](const VolumeInfo& info) {
        common.note("preview: " +
                    formatBytes(writePreview(out, *preview, ram, options.threads, common.progress.get())) +
                    ", of level " + std::to_string(previewLevel(info)) + ", with loss");
    };
    std::error_code ignored;
    if (preview && isStore(out) && std::filesystem::equivalent(arguments.in, out, ignored)) {
        makePreview(StoreReader(out, ram).info());
        return;
    }
    if (arguments.share && arguments.force)
        throw badFile("--share", "a new name, without --force",
                      "--force: a process that starts late would replace what the others made");
    requireStorePath(out, arguments.force || arguments.share);
    const InputOptions input = withFileLevel(arguments.in, arguments.input, common, UnsaidLevel::finest);
    const auto key = [&] {
        const std::string codec = options.codec == Codec::lz4 ? "" : "\n" + nameOf(options.codec);
        return importKey(arguments.in, input.key() + "\n" + options.unit + codec);
    };
    options.key = key(); // before anything is read
    options.checkSource = [&] {
        if (key() != options.key)
            throw badFile(arguments.in, "files that stay as they are while they are imported",
                          "a change meanwhile: import them again");
    };
    const auto source = openInput(arguments.in, input, out.parent_path(), common);
    common.detail("importing " + source->describe() + " to " + out.string());
    options.force = arguments.force;
    options.shared = arguments.share;
    options.progress = common.progress.get();
    options.reopen = [&] {
        return openInput(arguments.in, input, out.parent_path(), common, ChoiceNote::omitted);
    };
    try {
        if (preview)
            if (const std::string why = whyNoPreview(source->info()); !why.empty())
                throw badFile("--preview", "a volume that can have one", why);
        const ImportReport report = importToStore(*source, out, ram, options);
        noteImport(report, *source, out, ram, common);
        if (preview && !report.byOthers)
            makePreview(report.info);
    } catch (...) {
        common.progress->end();
        notePartsLeft(out, options.key, common);
        throw;
    }
}

} // namespace

void addImportCommand(Command& program, const CommonOptions& common, Action& action) {
    Command command = program.command("import", "Import files into a store, streaming, in bounded memory");
    auto arguments = std::make_shared<ImportArguments>();
    command
        .option("IN", arguments->in,
                "DICOM file or folder, or a volume's file: " + joinNames(volumeFileEndings()))
        .required();
    command.option("OUT", arguments->out, "store to write, OUT.zarr").required();
    command.flag("--force", arguments->force, "replace an existing store");
    command.flag("--share", arguments->share,
                 "several processes that run this command import together, on this and other machines");
    addSelectionOptions(command, arguments->input);
    addSpacingOption(command, arguments->input);
    command.option("--unit", arguments->unit,
                   "HU: the values are in HU, though the file cannot say so (NIfTI); SUVbw: for a PET whose "
                   "header has weight, dose and times");
    command.option("--codec", arguments->codec,
                   "compression of the store: " + joinNames(losslessCodecNames()) +
                       " (default: lz4; zstd is smaller and slower to write, none the reverse)");
    command.option("--preview", arguments->preview,
                   "8, 16, 32, 64 or 128: a small lossy store inside of the store, for first pictures by "
                   "address; the more, the "
                   "smaller and the worse");
    command.option("--ram", arguments->ram, "budget, e.g. 512MiB (default: 1 GiB at most)");
    command.footer("Example:\n  tessera import scans/abdomen abdomen.zarr --ram 512MiB");
    command.whenChosen(
        [arguments, &common, &action] { action = [arguments, &common] { runImport(*arguments, common); }; });
}

} // namespace tessera
