// tests/bench/accuracy/peers.cpp: see peers.h.
#include "tests/bench/accuracy/peers.h"

#include "core/base/error.h"
#include "core/base/files.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <optional>

namespace tessera::accuracy {
namespace {

/// Between quotes a comma is a character like others, and two quotes are one (RFC 4180).
std::vector<std::string> fieldsOf(const std::string& line) {
    std::vector<std::string> fields(1);
    bool quoted = false;
    for (std::size_t i = 0; i < line.size(); ++i) {
        const bool quote = line[i] == '"',
                   twice = quote && quoted && i + 1 < line.size() && line[i + 1] == '"';
        if (quote && !twice) {
            quoted = !quoted;
        } else if (line[i] == ',' && !quoted) {
            fields.emplace_back();
        } else {
            fields.back() += line[i];
            i += twice ? 1 : 0;
        }
    }
    for (std::string& field : fields)
        while (!field.empty() && (field.back() == '\r' || field.back() == ' '))
            field.pop_back();
    return fields;
}

} // namespace

std::vector<PeerPoint> loadPeers(const std::filesystem::path& file, const std::string& onlyScene) {
    refusePipeOrDevice(file);
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
    const auto scene = place("scene"), pixels = place("masked_pixels");
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
        points.push_back({scene ? fields[*scene] : onlyScene, fields[renderer], numberAt(time),
                          numberAt(error), pixels ? numberAt(*pixels) : 0});
    }
    return points;
}

} // namespace tessera::accuracy
