// viewer/cli/validate.cpp: `tessera validate STORE`: what is wrong with a store, and its repair.
#include "bricking/store/store_reader.h"
#include "bricking/validate/validate_store.h"
#include "core/base/address.h"
#include "core/base/error.h"
#include "core/base/shown_text.h"
#include "viewer/cli/commands.h"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

namespace tessera {
namespace {

struct ValidateArguments {
    std::string store, ram;
    bool repair = false, thorough = false;
};

std::string counted(std::uint64_t count, const char* what) {
    return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

/// Says what is wrong with it. Throws Error where something is and stays so.
void validateOne(const std::filesystem::path& path, const ValidateArguments& arguments,
                 const CommonOptions& common) {
    MemoryBudget ram("RAM", "--ram", budgetBytes(arguments.ram, "--ram", common));
    ValidateOptions options;
    options.repair = arguments.repair;
    options.thorough = arguments.thorough;
    options.progress = common.progress.get();
    const ValidateReport report = validateStore(path, ram, options);
    common.progress->end();
    for (const std::string& line : report.lines)
        std::printf("%s\n", printable(line).c_str());
    if (report.faults > report.lines.size())
        std::printf("and %s\n", counted(report.faults - report.lines.size(), "more fault").c_str());
    for (const std::string& note : report.notes)
        common.note(note);
    const std::string store = printable(path.string());
    if (report.faults == 0)
        return common.note(store + ": nothing is wrong (" + counted(report.chunks, "chunk") + " in " +
                           counted(report.shards, "shard") + ")");
    const std::string mended =
        report.mended == report.faults ? "all were" : std::to_string(report.mended) + " were";
    const std::string sum = store + ": " + counted(report.faults, "fault") +
                            (arguments.repair ? "; " + mended + " made again or removed" : "");
    if (report.mended == report.faults)
        return common.note(sum);
    throw Error(sum);
}

void runValidate(const ValidateArguments& arguments, const CommonOptions& common) {
    if (isAddress(arguments.store))
        throw badFile(withoutSecrets(arguments.store), "a store on a disk", "an address");
    const std::filesystem::path store = arguments.store, preview = store / kPreviewFolder;
    std::error_code ignored;
    if (std::filesystem::is_directory(preview, ignored)) // a store of its own
        validateOne(preview, arguments, common);
    validateOne(store, arguments, common);
}

} // namespace

void addValidateCommand(Command& program, const CommonOptions& common, Action& action) {
    Command command = program.command(
        "validate", "Check every byte of a store, and make again what follows from the rest of it");
    auto arguments = std::make_shared<ValidateArguments>();
    command.option("STORE", arguments->store, "store, NAME.zarr").required();
    command.flag(
        "--repair", arguments->repair,
        "make levels above the finest, statistics and metadata of levels again where they are damaged; "
        "remove what killed programs left");
    command.flag(
        "--thorough", arguments->thorough,
        "compute statistics and cells of labels again too, and compare them; without it their checksums "
        "must be right");
    command.option("--ram", arguments->ram, "budget, e.g. 512MiB (default: 1 GiB at most)");
    command.footer("Exit code 1 if something is wrong and stays so.\nExample:\n  tessera validate "
                   "abdomen.zarr --repair");
    command.whenChosen([arguments, &common, &action] {
        action = [arguments, &common] { runValidate(*arguments, common); };
    });
}

} // namespace tessera
