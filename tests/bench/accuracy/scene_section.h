// tests/bench/accuracy/scene_section.h: one scene on the page: its figures, times at equal error, errors
// at equal time, orders of convergence, and what each axis changes.
#pragma once

#include "tests/bench/accuracy/peers.h"
#include "tests/bench/accuracy/sweep.h"
#include "tests/bench/report/report.h"

#include <vector>

namespace tessera::accuracy {

/// @param peers  of all scenes; those of this one are shown beside it
bench::Report sceneSection(const Sweep& sweep, const std::vector<PeerPoint>& peers);

} // namespace tessera::accuracy
