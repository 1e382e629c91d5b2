// viewer/paths/markups.cpp: see markups.h.
#include "viewer/paths/markups.h"

#include "core/base/error.h"
#include "core/base/json_reader.h"
#include "core/base/shown_text.h"
#include "viewer/paths/point_line.h"

#include <limits>
#include <nlohmann/json.hpp>

namespace tessera {
namespace {

constexpr std::size_t kMostMarkups = 1000;

bool isLine(const std::string& type) {
    return type == "Curve" || type == "ClosedCurve" || type == "Line" || type == "Fiducial";
}

/// Whether the first two coordinates are from left to right and from back to front. Numbers are of old files.
bool isRas(const JsonValue& markup) {
    if (!markup.has("coordinateSystem"))
        return false;
    const std::string name = markup.at("coordinateSystem").oneOf({"LPS", "RAS", "0", "1"});
    return name == "RAS" || name == "0";
}

/// A word, or a code with its scheme and meaning.
void requireMillimetres(const JsonValue& markup) {
    if (!markup.has("coordinateUnits"))
        return;
    const JsonValue units = markup.at("coordinateUnits");
    const std::string unit =
        units.isList() && !units.items().empty() ? units.items().front().text() : units.text();
    if (unit != "mm")
        units.refuse("mm");
}

PlacedPoints pointsOf(const JsonValue& markup) {
    constexpr double kAny = std::numeric_limits<double>::max();
    requireMillimetres(markup);
    const double sign = isRas(markup) ? -1 : 1;
    PlacedPoints points;
    points.closed = markup.at("type").text() == "ClosedCurve";
    for (const JsonValue& point : markup.at("controlPoints").items(kMostPlacedPoints, "control points")) {
        if (point.has("positionStatus") && point.at("positionStatus").text() != "defined")
            continue;
        const JsonItems position = point.at("position").items();
        if (position.size() != 3)
            point.at("position").refuse("three numbers");
        points.mm.emplace_back(sign * position[0].number(-kAny, kAny), sign * position[1].number(-kAny, kAny),
                               position[2].number(-kAny, kAny));
    }
    return points;
}

} // namespace

bool isMarkups(const nlohmann::json& document) {
    return document.is_object() && document.contains("markups") && !document.contains("tesseraPath");
}

Path pathOfMarkups(const nlohmann::json& document, const std::string& where) {
    Path path;
    std::string types; // of what is no line
    std::size_t points = 0;
    for (const JsonValue& markup : JsonValue(document, where).at("markups").items(kMostMarkups, "markups")) {
        const std::string type = markup.at("type").text();
        if (!isLine(type)) {
            types += (types.empty() ? "" : ", ") + printable(type.substr(0, 40));
            continue;
        }
        const PlacedPoints placed = pointsOf(markup);
        if (placed.mm.size() < CentreLine::kFewestPoints) {
            types += (types.empty() ? "" : ", ") + type + " of fewer";
            continue;
        }
        path.lines.push_back(lineThrough(placed, markup.place()));
        points += path.lines.back().points.size();
        if (points > Path::kMostPoints)
            markup.refuse("at most " + std::to_string(Path::kMostPoints) + " points in all lines");
    }
    if (path.lines.empty())
        throw badFile(where, "a curve, a line or a point list of at least two points",
                      types.empty() ? "no markup" : types.substr(0, 200));
    return path;
}

} // namespace tessera
