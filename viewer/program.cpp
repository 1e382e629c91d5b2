// viewer/program.cpp: the `tessera` program: all of its commands.
#include "viewer/program.h"

#include "core/base/error.h"
#include "viewer/cli/commands.h"
#include "viewer/cli/input/remote_input.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string>
#include <unistd.h>
#include <vector>

namespace tessera {
namespace {

/// Starts `tessera-bench`, which is beside the program if it was built.
constexpr std::pair<const char*, const char*> kStudies[] = {
    {"accuracy", "Measure how wrong a scene's picture is, and what less error costs in time"},
    {"bench", "Measure first pictures and levels of detail; makes the pages of docs/ again"}};
constexpr const char* kStudyProgram = "tessera-bench";

void addCommands(Command& program, const CommonOptions& common, Action& action) {
    addImportCommand(program, common, action);
    addInfoCommand(program, common, action);
    addRenderCommand(program, common, action);
    addRedrawCommand(program, common, action);
    addBatchCommand(program, common, action);
#if TESSERA_WITH_WINDOW
    addViewCommand(program, common, action);
#endif
    addExportCommand(program, common, action);
    addPhantomCommand(program, common, action);
    addCentrelineCommand(program, common, action);
    addCoverageCommand(program, common, action);
    addMeshCommand(program, common, action);
    for (const auto& [name, about] : kStudies)
        program.command(name, about);
    addPresetCommand(program, common, action);
    addCacheCommand(program, common, action);
    addValidateCommand(program, common, action);
    addCompletionCommand(program, common, action);
    addManCommand(program, common, action);
}

/// True if the first word is a command of the other program.
bool asksForStudy(int argc, char** argv) {
    char** const end = argv + argc;
    char** const first = std::find_if(argv + 1, end, [](const char* word) { return word[0] != '-'; });
    return first != end && std::any_of(std::begin(kStudies), std::end(kStudies), [&](const auto& study) {
               return std::strcmp(study.first, *first) == 0;
           });
}

/// Becomes the other program.
int runStudy(char** argv) {
    const std::filesystem::path program =
        std::filesystem::read_symlink("/proc/self/exe").parent_path() / kStudyProgram;
    ::execv(program.c_str(), argv);
    const int error = errno;
    printProblem(program.string() + ": expected the program of measurements, found " +
                 (error == ENOENT ? "nothing; build it: cmake --build build/release --target tessera-bench"
                                  : std::string(std::strerror(error))));
    return 1;
}

} // namespace

int runProgram(int argc, char** argv) {
    if (argc > 1 && asksForStudy(argc, argv))
        return runStudy(argv);
    try {
        std::vector<std::string> words = reachedWords({argv, static_cast<std::size_t>(argc)});
        std::vector<char*> pointers;
        for (std::string& word : words)
            pointers.push_back(word.data());
        pointers.push_back(nullptr);
        return runCommands(argc, pointers.data(), addCommands);
    } catch (const InputError& error) {
        printProblem(error.what());
        return 2; // as for other bad input
    }
}

} // namespace tessera
