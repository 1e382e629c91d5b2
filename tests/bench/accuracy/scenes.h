// tests/bench/accuracy/scenes.h: the scenes of docs/measurements/accuracy.md: smooth, stiff and narrow ones,
// scans, lit and plain, and scenes that do not fit.
#pragma once

#include "tests/bench/accuracy/sweep.h"

#include <filesystem>
#include <string>
#include <vector>

namespace tessera::accuracy {

struct StandardScenes {
    std::vector<NamedScene> scenes;
    std::vector<std::string> leftOut; // a sentence each, with the reason
};

std::vector<std::string> standardSceneNames();

/// @param folder   generated volumes are written there, in the place of older ones; it must outlive the
/// scenes
/// @param scans    folder of public scans (tests/bench/lod/workbench.h); empty: scenes of scans are left
/// out
/// @param only     names; empty: all. Throws InputError for an unknown one, naming the nearest.
/// @param keep     all stores go to the folder, those of scans as copies: for keepScenes()
StandardScenes standardScenes(const std::filesystem::path& folder, const std::filesystem::path& scans,
                              const std::vector<std::string>& only, bool quick, std::size_t ramBytes,
                              const CommonOptions& common, bool keep = false);

/// Writes NAME.json of every scene into the folder of their stores. It holds the function's points and a
/// relative path, for its readers: tessera render, tests/bench/vtk_peer and a scene's other renderer. Throws
/// Error naming the file that cannot be written.
void keepScenes(const std::vector<NamedScene>& scenes, const std::filesystem::path& folder,
                std::size_t ramBytes);

} // namespace tessera::accuracy
