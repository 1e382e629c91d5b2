// core/base/json_schema.h: publishes a table of keys (json_fields.h) as a JSON Schema and as a Markdown
// table. Include from .cpp files only.
#pragma once

#include "core/base/json_fields.h"

#include <string>
#include <vector>

namespace tessera {

/// The schema of a document whose definitions are `parts`.
Schema documentSchema(const std::string& title, const std::string& about, Schema root, Schema parts);
/// As text to publish, without options, the same for the same schema: values that fit a line are on one line.
std::string schemaText(const Schema& schema);

/// A key that holds a value, and its allowed values.
struct KeyRow {
    std::string path; // "volumes[].transferFunction.materials[].from"
    std::string value, preset, about;
    std::vector<std::string> names; // of a key that takes one of them
    Schema schema;                  // of the value
    KeyOption option;
};
/// All keys of a document that hold values, not only further keys, in the order of the tables.
std::vector<KeyRow> keysOf(const Schema& document);
/// The keys as a Markdown table.
std::string keyTable(const std::vector<KeyRow>& keys);

} // namespace tessera
