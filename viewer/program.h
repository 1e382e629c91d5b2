// viewer/program.h: the whole program as a function, so that tests can run it in a forked child without
// paying for the loading of 280 shared libraries each time.
#pragma once

namespace tessera {

/// Parses, runs one command, and turns errors into one line on stderr.
/// @return the exit code: 0 success, 2 bad use or bad input, 1 anything else
int runProgram(int argc, char** argv);

} // namespace tessera
