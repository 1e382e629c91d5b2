// viewer/cli/redraw/redraw_report.h: what `tessera redraw` found: the data, and what differs from the figure
// before.
#pragma once

#include "viewer/cli/redraw/differences.h"
#include "viewer/cli/redraw/find_data.h"
#include "viewer/cli/redraw/run_redraw.h"

#include <nlohmann/json_fwd.hpp>
#include <vector>

namespace tessera {

struct RedrawReport {
    std::vector<FoundData> data;
    ManifestDifferences differences;
    PixelDifferences pixels;

    /// True if the data are not those of the figure.
    bool isDataAnother() const;
    /// True if something is known for which pixels may differ.
    bool isKnownToDiffer() const;
};

/// On stdout, for people.
/// @param now  the manifest of the new picture, of a figure of panels that of the first
void printReport(const RedrawReport& report, const nlohmann::json& now);
nlohmann::json reportJson(const RedrawArguments& arguments, const RedrawReport& report);

} // namespace tessera
