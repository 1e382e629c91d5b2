// bricking/import/zarr/zarr_node.cpp: see zarr_node.h.
#include "bricking/import/zarr/zarr_node.h"

#include "bricking/store/folder_below.h"
#include "bricking/store/store_files.h"
#include "core/base/error.h"
#include "core/base/json_reader.h"

#include <nlohmann/json.hpp>
#include <string_view>
#include <system_error>
#include <utility>

namespace tessera {
namespace {

using nlohmann::json;

/// The text with null in place of NaN, Infinity and -Infinity, as Python and JavaScript write such numbers
/// where JSON has none. Strings stay.
std::string withoutNonFinite(const std::string& text, std::size_t& count) {
    std::string out;
    bool isString = false;
    for (std::size_t i = 0; i < text.size();) {
        const std::string_view rest = std::string_view(text).substr(i);
        if (isString && rest.size() > 1 && rest[0] == '\\') {
            out += rest.substr(0, 2);
            i += 2;
            continue;
        }
        isString = isString != (rest[0] == '"');
        const auto skipped = [&](std::string_view word) {
            if (isString || !rest.starts_with(word))
                return false;
            out += "null";
            i += word.size();
            ++count;
            return true;
        };
        if (skipped("NaN") || skipped("-Infinity") || skipped("Infinity"))
            continue;
        out += rest[0];
        ++i;
    }
    return out;
}

/// A document of a node's folder; null: there is none.
std::shared_ptr<const json> documentIn(ZarrNode& node, const char* name, bool mayBeLenient) {
    const auto text = readText(*node.folder, name, node.path, kMaxJsonBytes);
    if (!text)
        return nullptr;
    const std::string where = (node.path / name).string();
    std::size_t passedOver = 0;
    const std::string plain = mayBeLenient ? withoutNonFinite(*text, passedOver) : *text;
    auto document = std::make_shared<const json>(parseStrictJson(plain, where));
    if (!document->is_object())
        throw badFile(where, "an object", "another JSON value");
    if (passedOver > 0)
        node.notes.push_back(
            std::string(name) + ": " + std::to_string(passedOver) +
            (passedOver == 1 ? " value NaN or Infinity is ignored" : " values NaN or Infinity are ignored"));
    return document;
}

/// @param folder  of the path, open
std::optional<ZarrNode> nodeOf(const std::filesystem::path& path, StoreFolder folder) {
    ZarrNode node;
    node.path = path;
    node.folder = std::make_shared<const StoreFolder>(std::move(folder));
    const auto fileOf = [&](const char* name) { return (path / name).string(); };
    // The metadata of an array stay strict: a fill value that is null would be another number.
    if (auto document = documentIn(node, "zarr.json", true)) {
        const JsonValue root(*document, fileOf("zarr.json"));
        node.version = root.at("zarr_format").integer(3, 3);
        node.isArray = root.at("node_type").oneOf({"array", "group"}) == "array";
        if (node.isArray && !node.notes.empty())
            document = documentIn(node, "zarr.json", false);
        node.metadataFile = node.attributesFile = fileOf("zarr.json");
        node.metadata = node.attributes = document;
        return node;
    }
    auto array = documentIn(node, ".zarray", false);
    node.isArray = array != nullptr;
    node.metadataFile = fileOf(node.isArray ? ".zarray" : ".zgroup");
    node.metadata = array ? array : documentIn(node, ".zgroup", false);
    node.version =
        node.metadata ? JsonValue(*node.metadata, node.metadataFile).at("zarr_format").integer(2, 2) : 2;
    if (!node.isArray)
        node.attributes = documentIn(node, ".zattrs", true);
    node.attributesFile = fileOf(".zattrs");
    if (!node.metadata && !node.attributes)
        return std::nullopt;
    const auto empty = std::make_shared<const json>(json::object());
    if (!node.metadata)
        node.metadata = empty;
    if (!node.attributes)
        node.attributes = empty;
    return node;
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
    return isZarr(path) ? nodeOf(path, openFolder(path)) : std::nullopt;
}

std::optional<ZarrNode> readZarrNode(const ZarrNode& group, const std::string& below) {
    auto folder = openFolderIn(*group.folder, below, group.path);
    return folder ? nodeOf(group.path / below, *std::move(folder)) : std::nullopt;
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
