// tests/bench/tessera_bench.cpp: `tessera-bench`: what `tessera accuracy` and `tessera bench` measure.
#include "tests/bench/study_commands.h"

namespace {

void addCommands(tessera::Command& program, const tessera::CommonOptions& common, tessera::Action& action) {
    tessera::addAccuracyCommand(program, common, action);
    tessera::addBenchCommand(program, common, action);
}

} // namespace

int main(int argc, char** argv) {
    return tessera::runCommands(argc, argv, addCommands);
}
