// core/base/json_schema.h: what is published of a table of keys (json_fields.h): a JSON Schema, and a table
// for people. Include from .cpp files only.
#pragma once

#include "core/base/json_fields.h"

#include <string>
#include <vector>

namespace tessera {

/// The schema of a document whose definitions are `parts`.
Schema documentSchema(const std::string& title, const std::string& about, Schema root, Schema parts);
/// The same text for the same schema: what fits a line stands on one.
std::string schemaText(const Schema& schema);

/// A key that holds a value, and what may stand there.
struct KeyRow {
    std::string path; // "volumes[].transferFunction.materials[].from"
    std::string value, preset, about;
    std::vector<std::string> names; // of a key that takes one of them
};
/// All keys of a document that hold more than further keys, in the order of the tables.
std::vector<KeyRow> keysOf(const Schema& document);
/// They as a table in Markdown.
std::string keyTable(const std::vector<KeyRow>& keys);

} // namespace tessera
