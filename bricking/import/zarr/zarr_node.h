// bricking/import/zarr/zarr_node.h: a group or an array of Zarr, version 2 or 3, as other programs write
// them: its metadata and attributes. Zarr specifications: zarr-specs.readthedocs.io.
#pragma once

#include "bricking/store/store_files.h"

#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

struct ZarrNode {
    std::filesystem::path path;                // its folder
    std::shared_ptr<const StoreFolder> folder; // the same, open: what is below is read from it
    int version = 0;                           // 2 or 3
    bool isArray = false;
    /// .zarray, .zgroup or zarr.json; an empty object for a group of version 2.
    std::shared_ptr<const nlohmann::json> metadata;
    std::string metadataFile; // for messages
    /// The document that holds the attributes: .zattrs, or `metadata` (in "attributes"). Those of an array of
    /// version 2 are not read: an empty object.
    std::shared_ptr<const nlohmann::json> attributes;
    std::string attributesFile;
    std::vector<std::string> notes; // what was passed over
};

/// True if the folder has a file of Zarr's metadata.
bool isZarr(const std::filesystem::path& folder);

/// Of attributes, in which programs write numbers that are no JSON, NaN and Infinity count as null. Nullopt:
/// there is no Zarr. Throws InputError naming the file for metadata that are damaged, larger than
/// kMaxJsonBytes (core/base/json_reader.h), links, or of another version.
std::optional<ZarrNode> readZarrNode(const std::filesystem::path& folder);
/// The same of a path below a group, as metadata name it. Throws InputError naming a link on the way, too.
/// @param below  of pathBelow() (ome_image.h)
std::optional<ZarrNode> readZarrNode(const ZarrNode& group, const std::string& below);

/// The same, where there has to be one: else throws InputError naming the path.
/// @param expected  "a group or an array of Zarr"
ZarrNode requireZarrNode(const std::filesystem::path& folder, const char* expected);
ZarrNode requireZarrNode(const ZarrNode& group, const std::string& below, const char* expected);

} // namespace tessera
