// tests/bench/suite.h: the pictures that are compared, as a JSON file of rows. Each row has a store by a name
// that the command line gives a path, a scene unlit and lit, and sizes.
#pragma once

#include "core/scene/scene.h"

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace tessera::bench {

/// One picture.
struct SuitePicture {
    std::string name; // of the scene: "bone"
    std::string store;
    std::filesystem::path storePath; // empty: none was given
    Scene scene;                     // of the store and the size
    bool quick = false;              // one of the few that a first look draws
    std::string label() const;       // "bone-lit-512x512"
};

/// In the file's order, unlit before lit.
/// @param stores  paths by name
/// Throws InputError naming the file and the JSON path.
std::vector<SuitePicture> readSuite(const std::filesystem::path& file,
                                    const std::map<std::string, std::filesystem::path>& stores);

/// "torso=build/torso.zarr,chest=build/chest.zarr"; throws InputError naming option.
std::map<std::string, std::filesystem::path> parseStores(const std::string& text, const std::string& option);

} // namespace tessera::bench
