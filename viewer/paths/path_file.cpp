// viewer/paths/path_file.cpp: see path_file.h.
#include "viewer/paths/path_file.h"

#include "core/base/json_reader.h"
#include "viewer/paths/markups.h"
#include "viewer/paths/point_table.h"

#include <nlohmann/json.hpp>

namespace tessera {

Path loadPathFile(const std::filesystem::path& file) {
    if (isPointTable(file))
        return pathOfTable(file);
    const std::string where = file.string(), text = readTextFile(where);
    const nlohmann::json document = parseStrictJson(text, where);
    return isMarkups(document) ? pathOfMarkups(document, where) : parsePath(text, where);
}

} // namespace tessera
