// viewer/cli/redraw/run_redraw.h: `tessera redraw`: draws a picture again from its own manifest, and says
// what is another than it was.
#pragma once

#include "viewer/cli/options/options.h"

#include <string>
#include <vector>

namespace tessera {

struct RedrawArguments {
    std::string figure, out;                    // out "": the picture is compared, and not kept
    std::vector<std::string> data, changes;     // changes: "KEY=VALUE"
    std::string path;                           // of a picture along a line; "": its own
    std::string engine, device, ram, gpuMemory; // "": as they were
    bool json = false;
};

/// Throws InputError naming an option or a file, as drawing does, and Error where pixels differ though
/// nothing that is known does.
void runRedraw(const RedrawArguments& arguments, const CommonOptions& common);

} // namespace tessera
