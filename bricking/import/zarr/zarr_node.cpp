// bricking/import/zarr/zarr_node.cpp: see zarr_node.h.
#include "bricking/import/zarr/zarr_node.h"

#include "bricking/store/store_files.h"
#include "core/base/address.h"
#include "core/base/error.h"
#include "core/base/json_reader.h"

#include <nlohmann/json.hpp>
#include <system_error>

namespace tessera {
namespace {

using nlohmann::json;

/// A document of the folder; null: there is none.
std::shared_ptr<const json> documentIn(const StoreFolder& folder, const std::filesystem::path& path,
                                       const char* name) {
    const auto text = readText(folder, name, path, kMaxJsonBytes);
    if (!text)
        return nullptr;
    const std::string where = (path / name).string();
    auto document = std::make_shared<const json>(parseStrictJson(*text, where));
    if (!document->is_object())
        throw badFile(where, "an object", "another JSON value");
    return document;
}

} // namespace

bool isZarr(const std::filesystem::path& folder) {
    const auto place = remotePlaceOf(folder);
    std::error_code none;
    for (const char* name : {"zarr.json", ".zarray", ".zgroup", ".zattrs"})
        if (place ? place->files->sizeOf(place->nameOf(name)).has_value()
                  : std::filesystem::is_regular_file(folder / name, none))
            return true;
    return false;
}

std::optional<ZarrNode> readZarrNode(const std::filesystem::path& path) {
    if (!isZarr(path))
        return std::nullopt;
    const StoreFolder folder = openFolder(path);
    ZarrNode node;
    node.path = path;
    const auto fileOf = [&](const char* name) { return (path / name).string(); };
    if (auto document = documentIn(folder, path, "zarr.json")) {
        const JsonValue root(*document, fileOf("zarr.json"));
        node.version = root.at("zarr_format").integer(3, 3);
        node.isArray = root.at("node_type").oneOf({"array", "group"}) == "array";
        node.metadataFile = node.attributesFile = fileOf("zarr.json");
        node.metadata = node.attributes = document;
        return node;
    }
    auto array = documentIn(folder, path, ".zarray");
    node.isArray = array != nullptr;
    node.metadataFile = fileOf(node.isArray ? ".zarray" : ".zgroup");
    node.metadata = array ? array : documentIn(folder, path, ".zgroup");
    node.version =
        node.metadata ? JsonValue(*node.metadata, node.metadataFile).at("zarr_format").integer(2, 2) : 2;
    if (!node.isArray)
        node.attributes = documentIn(folder, path, ".zattrs");
    node.attributesFile = fileOf(".zattrs");
    const auto empty = std::make_shared<const json>(json::object());
    if (!node.metadata)
        node.metadata = empty;
    if (!node.attributes)
        node.attributes = empty;
    return node;
}

std::optional<ZarrNode> readZarrNode(const ZarrNode& group, const std::string& below) {
    std::filesystem::path path = group.path;
    std::error_code none;
    for (const std::filesystem::path& name : std::filesystem::path(below)) {
        path /= name;
        if (!isAddress(path) && std::filesystem::is_symlink(path, none))
            throw badFile(path.string(), "a folder", "a symbolic link");
    }
    return readZarrNode(path);
}

ZarrNode requireZarrNode(const std::filesystem::path& folder, const char* expected) {
    if (auto node = readZarrNode(folder))
        return *std::move(node);
    throw badFile(folder.string(), expected, "no Zarr there");
}

ZarrNode requireZarrNode(const ZarrNode& group, const std::string& below, const char* expected) {
    if (auto node = readZarrNode(group, below))
        return *std::move(node);
    throw badFile((group.path / below).string(), expected, "no Zarr there");
}

} // namespace tessera
