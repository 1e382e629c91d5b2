// viewer/accuracy/scenes.h: the five scenes of docs/accuracy.md (NUMERICS C7): what is smooth, what is stiff,
// what is narrow, what is a scan, and what does not fit.
#pragma once

#include "viewer/accuracy/sweep.h"

#include <filesystem>
#include <string>
#include <vector>

namespace tessera::accuracy {

struct StandardScenes {
    std::vector<NamedScene> scenes;
    std::vector<std::string> leftOut; // a sentence each, with the reason
};

std::vector<std::string> standardSceneNames();

/// @param scratch  generated volumes are written there; it must outlive the scenes
/// @param scans    folder of public scans (viewer/bench/workbench.h); empty: scenes of scans are left out
/// @param only     names; empty: all. Throws InputError for an unknown one, naming the nearest.
StandardScenes standardScenes(const std::filesystem::path& scratch, const std::filesystem::path& scans,
                              const std::vector<std::string>& only, bool quick, std::size_t ramBytes,
                              const CommonOptions& common);

} // namespace tessera::accuracy
