// viewer/cli/man.cpp: `tessera man FOLDER`: writes the pages of the manual, of the program and of each
// command.
#include "core/base/error.h"
#include "core/base/output_file.h"
#include "viewer/cli/commands.h"
#include "viewer/cli/options/command_table.h"
#include "viewer/cli/pages/manual_pages.h"

#include <filesystem>
#include <memory>
#include <regex>
#include <string>

namespace tessera {
namespace {

struct ManArguments {
    std::string folder, date;
};

void writePages(const ManArguments& arguments, const CommandRow& program, const CommonOptions& common) {
    if (!arguments.date.empty() && !std::regex_match(arguments.date, std::regex("\\d{4}-\\d{2}-\\d{2}")))
        throw badFile("--date", "YYYY-MM-DD", "\"" + arguments.date + "\"");
    const auto pages = manualPages(program, {"Tessera", TESSERA_VERSION, arguments.date});
    for (const auto& [name, text] : pages)
        writeOutputFile(std::filesystem::path(arguments.folder) / name, text);
    common.note("wrote " + std::to_string(pages.size()) + " pages to " + arguments.folder);
}

} // namespace

void addManCommand(Command& program, const CommonOptions& common, Action& action) {
    Command command =
        program.command("man", "Write the pages of the manual, of the program and of each command");
    const auto a = std::make_shared<ManArguments>();
    command.option("FOLDER", a->folder, "folder that the pages go to; pages there are replaced").required();
    command.option("--date", a->date, "date of the pages, YYYY-MM-DD (default: none)");
    command.footer("Packages install them. Elsewhere:\nExample:\n  tessera man .\n  man ./tessera-render.1");
    command.whenChosen([a, program, &common, &action] {
        action = [a, program, &common] { writePages(*a, program.table(), common); };
    });
}

} // namespace tessera
