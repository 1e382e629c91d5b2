// viewer/cli/input/selection_options.cpp: see selection_options.h.
#include "viewer/cli/input/selection_options.h"

namespace tessera {

void addSelectionOptions(Command& command, InputOptions& input) {
    command.option("--series", input.series, "source files: number of the DICOM series, as listed")
        .check(wholeNumberFrom(1));
    command.flag("--largest", input.largest, "source files: the largest CT of a folder with several volumes");
    command
        .option("--phase", input.phase,
                "source files: number of the phase, if a series has several images at each position")
        .check(wholeNumberFrom(1));
    command.flag("--resample-z", input.resampleZ, "source files: interpolate uneven slices to even spacing");
    command.flag("--allow-missing", input.allowMissing,
                 "source files: leave out files that could be slices and cannot be read");
}

} // namespace tessera
