// viewer/cli/manifest/picture_data.h: the data of a picture by their content: what its manifest names in
// place of paths, which folders' names make private.
#pragma once

#include "bricking/store/store_reader.h"
#include "core/scene/scene.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

namespace tessera {

/// A store or a file that a picture was made from.
struct PictureData {
    enum class Kind { volume, labels, labelNames, mesh, environment };
    Kind kind = Kind::volume;
    std::size_t number = 0;       // from 0: of volumes, or of meshes
    std::string contentHash = {}; // 16 digits; "" where it is not known, as of a file behind an address
    glm::ivec3 extentVoxels{0};   // of volumes and labels
    std::string type = {};        // of a volume's values: "int16"
    std::uint64_t bytes = 0;      // of files
    std::string extension = {};   // of files and of labels: ".ply"
};

/// "volume 1", "labels of volume 1", "mesh 2", "environment"
std::string nameOf(const PictureData& data);
/// Where a scene names its file or store. The scene must have it.
std::filesystem::path& pathOf(const PictureData& data, Scene& scene);
const std::filesystem::path& pathOf(const PictureData& data, const Scene& scene);

/// All data of a scene, in the order volumes, labels, names of labels, meshes, environment.
/// @param stores  of its volumes, in order
std::vector<PictureData> dataOf(const Scene& scene, Stores stores);
/// The hash of a file's bytes. Throws InputError naming it where it cannot be read.
std::string contentHashOfFile(const std::filesystem::path& path);

/// The manifest's "data".
nlohmann::json dataJson(std::span<const PictureData> data);
/// The data of a manifest; of one without "data" from the keys that name volumes and from its scene.
/// @param scene  the manifest's
/// Throws InputError naming `where` for keys of another form.
std::vector<PictureData> dataOfManifest(const nlohmann::json& manifest, const Scene& scene,
                                        const std::string& where);

} // namespace tessera
