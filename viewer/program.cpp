// viewer/program.cpp: the `tessera` program: parses, runs one command, and turns errors into one line and an
// exit code: 0 success, 2 bad use or bad input, 128 and the signal's number after a signal, 1 anything else.
#include "core/error.h"
#include "core/interrupt.h"
#include "core/nearest_name.h"
#include "core/output_file.h" // finishStandardOutput
#include "viewer/commands/commands.h"
#include "viewer/options/option_names.h"
#include "viewer/options/option_values.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fcntl.h>
#include <new>
#include <unistd.h>

namespace tessera {
namespace {

constexpr int kExitFailure = 1, kExitBadInput = 2; // and 128 + signal

std::vector<std::string> commandNames(const CLI::App& program) {
    std::vector<std::string> names;
    for (const CLI::App* command : program.get_subcommands({}))
        names.push_back(command->get_name());
    return names;
}

/// A mistyped command, found before the parser, which would only say that one is missing.
void checkCommand(const CLI::App& program, int argc, char** argv) {
    const auto isWord = [](const char* argument) { return argument[0] != '-'; };
    char** const first = std::find_if(argv + 1, argv + argc, isWord);
    if (first == argv + argc)
        return;
    const std::vector<std::string> names = commandNames(program);
    if (std::find(names.begin(), names.end(), *first) == names.end())
        throw badFile("command line", "a command (" + joinNames(names) + ")",
                      "\"" + std::string(*first) + "\"; nearest: \"" + nearestName(*first, names) + "\"");
}

/// The parser's complaint, with the nearest option where one was unknown.
std::string explainParseError(const CLI::App& program, const CLI::ParseError& error) {
    std::string message = error.what();
    std::replace(message.begin(), message.end(), '\n', ' ');
    std::vector<std::string> options;
    const auto collect = [&options](const CLI::App& app) {
        for (const CLI::Option* option : app.get_options())
            for (const std::string& longName : option->get_lnames())
                options.push_back("--" + longName);
    };
    collect(program);
    std::string command;
    for (const CLI::App* chosen : program.get_subcommands()) {
        collect(*chosen);
        command = " " + chosen->get_name();
    }
    const std::vector<std::string> extras = program.remaining(true);
    const auto unknown = std::find_if(extras.begin(), extras.end(),
                                      [](const std::string& extra) { return extra.rfind("--", 0) == 0; });
    if (unknown != extras.end()) {
        const std::string likely = likelyOption(*unknown, options);
        message = "unknown option " + *unknown + (likely.empty() ? "" : "; nearest: " + likely);
    }
    return message + " (tessera" + command + " --help shows how)";
}

/// A descriptor that the caller closed would become that of the next file that is opened, and what is printed
/// would land there. Opened the wrong way round, so that printing to it still fails.
void occupyStandardDescriptors() {
    for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
        if (::fcntl(descriptor, F_GETFD) < 0)
            ::open("/dev/null", descriptor == STDIN_FILENO ? O_WRONLY : O_RDONLY); // the lowest that is free
}

int run(int argc, char** argv) {
    occupyStandardDescriptors();
    CommonOptions common;
    Action action;
    CLI::App program(
        "Tessera draws CT volumes of any size inside a stated memory budget. Not for diagnosis.");
    program.name("tessera");
    program.set_version_flag("--version", "tessera " TESSERA_VERSION);
    program.add_flag("-q,--quiet", common.quiet, "errors only");
    program.add_flag("-v,--verbose", common.verbose, "more about what is done");
    program.fallthrough(); // -q and -v may stand behind the command too
    program.require_subcommand(1);
    program.footer("Example:\n  tessera phantom torso --size 128x96x150 -o torso.zarr\n"
                   "  tessera render torso.zarr -o torso.png");
    addImportCommand(program, common, action);
    addInfoCommand(program, common, action);
    addRenderCommand(program, common, action);
#if TESSERA_WITH_WINDOW
    addViewCommand(program, common, action);
#endif
    addPhantomCommand(program, common, action);
    addCentrelineCommand(program, common, action);
    addCoverageCommand(program, common, action);
    addAccuracyCommand(program, common, action);
    addBenchCommand(program, common, action);
    addPresetCommand(program, common, action);
    addCacheCommand(program, common, action);
    checkCommand(program, argc, argv);
    try {
        program.parse(argc, argv);
    } catch (const CLI::Success& success) { // --help, --version
        const int code = program.exit(success);
        finishStandardOutput();
        return code;
    } catch (const CLI::ParseError& error) {
        throw InputError(explainParseError(program, error));
    }
    refuseEmptyValues(program);
    catchInterrupts();
    common.progress = std::make_shared<Progress>(common.verbosity());
    action();
    finishStandardOutput();
    return 0;
}

} // namespace

int runProgram(int argc, char** argv) {
    try {
        return run(argc, argv);
    } catch (const InputError& error) {
        printProblem(error.what());
        return kExitBadInput;
    } catch (const Interrupted& interrupted) {
        printProblem(interrupted.what());
        return interrupted.exitCode();
    } catch (const std::bad_alloc&) {
        printProblem("out of memory");
    } catch (const std::exception& error) {
        printProblem(error.what());
    }
    return kExitFailure;
}

} // namespace tessera
