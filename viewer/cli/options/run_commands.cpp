// viewer/cli/options/run_commands.cpp: see run_commands.h.
#include "viewer/cli/options/run_commands.h"

#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/output_file.h" // finishStandardOutput

#include <fcntl.h>
#include <new>
#include <unistd.h>

namespace tessera {
namespace {

constexpr int kExitFailure = 1, kExitBadInput = 2; // and 128 + signal

/// Opens closed standard descriptors. Otherwise the next opened file would get the number, and printed text
/// would land in it. They are opened in the wrong direction, so that printing to them still fails.
void occupyStandardDescriptors() {
    for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
        if (::fcntl(descriptor, F_GETFD) < 0)
            ::open("/dev/null",
                   descriptor == STDIN_FILENO ? O_WRONLY : O_RDONLY); // gets the lowest free descriptor
}

int run(int argc, char** argv, AddCommands addCommands) {
    occupyStandardDescriptors();
    CommonOptions common;
    Action action;
    CommandLine line("tessera", TESSERA_VERSION,
                     "Tessera draws CT volumes of any size within a memory budget. Not for diagnosis.");
    Command program = line.program();
    program.flag("-q,--quiet", common.quiet, "errors only");
    program.flag("-v,--verbose", common.verbose, "print more details");
    program.footer("Example:\n  tessera phantom torso --size 128x96x150 -o torso.zarr\n"
                   "  tessera render torso.zarr -o torso.png");
    addCommands(program, common, action);
    if (const std::optional<int> code = line.parse(argc, argv))
        return *code;
    catchInterrupts();
    common.progress = std::make_shared<Progress>(common.verbosity());
    action();
    finishStandardOutput();
    return 0;
}

} // namespace

int runCommands(int argc, char** argv, AddCommands addCommands) {
    try {
        return run(argc, argv, addCommands);
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
