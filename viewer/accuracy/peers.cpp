// viewer/accuracy/peers.cpp: see peers.h.
#include "viewer/accuracy/peers.h"

#include "core/error.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <sstream>

namespace tessera::accuracy {
namespace {

std::vector<std::string> fieldsOf(const std::string& line) {
    std::vector<std::string> fields;
    std::istringstream text(line);
    for (std::string field; std::getline(text, field, ',');) {
        while (!field.empty() && (field.back() == '\r' || field.back() == ' '))
            field.pop_back();
        fields.push_back(field);
    }
    return fields;
}

} // namespace

std::vector<PeerPoint> loadPeers(const std::filesystem::path& file, const std::string& onlyScene) {
    std::ifstream in(file);
    std::string line;
    if (!std::getline(in, line))
        throw badFile(file.string(), "a CSV file with a line of column names", "none");
    const std::vector<std::string> names = fieldsOf(line);
    const auto place = [&](const std::string& name) -> std::optional<std::size_t> {
        const auto found = std::find(names.begin(), names.end(), name);
        return found == names.end() ? std::nullopt
                                    : std::optional(static_cast<std::size_t>(found - names.begin()));
    };
    const auto needed = [&](const std::string& name) {
        const auto at = place(name);
        if (!at)
            throw badFile(file.string(), "a column \"" + name + "\"", "columns " + line);
        return *at;
    };
    const std::size_t renderer = needed("renderer"), time = needed("time_min_ms"), error = needed("rmse");
    const auto scene = place("scene");
    std::vector<PeerPoint> points;
    for (int number = 2; std::getline(in, line); ++number) {
        if (line.empty())
            continue;
        const std::vector<std::string> fields = fieldsOf(line);
        const std::string where = file.string() + ", line " + std::to_string(number);
        if (fields.size() < names.size())
            throw badFile(where, std::to_string(names.size()) + " fields", std::to_string(fields.size()));
        const auto numberAt = [&](std::size_t at) {
            char* end = nullptr;
            const double value = std::strtod(fields[at].c_str(), &end);
            if (fields[at].empty() || *end != '\0' || !(value >= 0) || !std::isfinite(value))
                throw badFile(where, "a number in \"" + names[at] + "\"", "\"" + fields[at] + "\"");
            return value;
        };
        points.push_back(
            {scene ? fields[*scene] : onlyScene, fields[renderer], numberAt(time), numberAt(error)});
    }
    return points;
}

} // namespace tessera::accuracy
