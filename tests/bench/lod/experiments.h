// tests/bench/lod/experiments.h: the experiments on volumes, a file each. Each returns a report; nothing
// is written.
#pragma once

#include "tests/bench/lod/workbench.h"

namespace tessera::bench {

/// Flat against hierarchical selections: table 2.1 (hierarchy_report.cpp).
Report hierarchyReport(const Workbench& bench);
/// What each edge function costs the picture (edge_cost.cpp).
Report edgeCostReport(const Workbench& bench);
/// Full, limited and naive sampling: table 2.2 (adaptive_sampling.cpp).
Report samplingReport(const Workbench& bench);
/// Samples against an oracle's, with each occupancy map (skipping.cpp).
Report skippingReport(const Workbench& bench);
/// Data reductions by transfer function, camera and levels: figure 2.27 (reductions.cpp).
Report reductionsReport(const Workbench& bench);
/// Predicted against true errors, and choices made by them and by less (prediction.cpp).
Report predictionReport(const Workbench& bench);
/// Ambient occlusion at data reductions: table 6.1 (occlusion_cost.cpp).
Report occlusionReport(const Workbench& bench);
/// What fills a picture, by what its camera is fitted to (framing.cpp).
Report framingReport(const Workbench& bench);
/// Normals by the kind of gradient, against surfaces' own (grain.cpp).
Report grainReport(const Workbench& bench);

/// Promised errors against true ones, and whether --max-error holds (calibration_report.cpp).
Report calibrationReport(const Workbench& bench);

} // namespace tessera::bench
