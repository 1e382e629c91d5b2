// tests/bench/papers/papers.h: techniques of the four papers that Tessera follows, beside what it does in
// their place. Each report is a section of docs/measurements/papers.md.
#pragma once

#include "tests/bench/lod/workbench.h"
#include "tests/bench/report/report.h"

namespace tessera::bench {

/// One of what the papers describe.
struct PaperSystem {
    const char* id;
    const char* what;
    const char* where;  // in the sources
    const char* status; // whether it is used, or what is in its place
    /// A section of a page of docs/measurements/, as links have it: "light.md#looks"; or a file of tests.
    const char* measured;
};
/// All 90, by paper.
const std::vector<PaperSystem>& paperSystems();
/// Their table.
Report systemsReport(const Workbench& bench);

/// Sampling hulls (Imagire et al. 2007): their aliasing beside that of slices, time by hulls and samples, and
/// time at equal error beside the march.
Report hullsReport(const Workbench& bench);

/// EWA volume splatting beside the march.
Report splatsReport(const Workbench& bench);

/// Starts and ends of rays in object order (course notes, 2.2 and 2.3).
Report objectOrderReport(const Workbench& bench);

/// Presence bits of values (course notes, 2.7.2): what they cull beyond ranges.
Report presenceReport(const Workbench& bench);

/// Lossy codes beside coarser levels as previews (course notes, 2.9.1).
Report previewsReport(const Workbench& bench);

} // namespace tessera::bench
