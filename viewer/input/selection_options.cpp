// viewer/input/selection_options.cpp: see selection_options.h.
#include "viewer/input/selection_options.h"

#include "viewer/options/option_values.h"

#include <CLI/CLI.hpp>

namespace tessera {

void addSelectionOptions(CLI::App& command, InputOptions& input) {
    command.add_option("--series", input.series, "source files: number of the DICOM series, as listed")
        ->check(wholeNumberFrom(1));
    command.add_flag("--largest", input.largest, "source files: of a folder with several, the largest CT");
    command
        .add_option("--phase", input.phase,
                    "source files: of a series with several pictures at each place, number of the phase")
        ->check(wholeNumberFrom(1));
    command.add_flag("--resample-z", input.resampleZ,
                     "source files: interpolate uneven slices to even spacing");
    command.add_flag("--allow-missing", input.allowMissing,
                     "source files: leave out files that could be slices and cannot be read");
}

} // namespace tessera
