// tests/bench/accuracy/peers.h: curves of other renderers, measured elsewhere on the same scenes and
// handed over as CSV.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace tessera::accuracy {

struct PeerPoint {
    std::string scene, renderer;
    double ms = 0, rmse = 0; // least time of a frame; linear, over the pixels that the reference shows
    double pixels = 0;       // how many these are; 0: not told
};

/// Columns "renderer", "time_min_ms" and "rmse", in any order, others are passed over; "scene" too, or else
/// every row is of `onlyScene`; "masked_pixels" where it is known. Throws InputError naming the file and the
/// line.
std::vector<PeerPoint> loadPeers(const std::filesystem::path& file, const std::string& onlyScene);

} // namespace tessera::accuracy
