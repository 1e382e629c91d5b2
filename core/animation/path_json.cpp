// core/animation/path_json.cpp: paths as JSON, read strictly: see path.h.
#include "core/animation/path.h"
#include "core/base/error.h"
#include "core/base/json_reader.h"
#include "core/scene/cuts_json.h"
#include "core/scene/lighting_json.h"
#include "core/scene/transfer_json.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace tessera {
namespace {

using nlohmann::json;
using Keys = std::vector<std::string>;

const Keys kPathKeys = {"tesseraPath", "volume", "lumen", "lines", "keyframes", "flight", "framesPerSecond"};
const Keys kVolumeOfPathKeys = {"contentHash", "size"};
const Keys kLumenKeys = {"threshold", "side",    "noise",      "leaks",     "leavesAt",
                         "unsure",    "surface", "branchesTo", "branchWall"};
const Keys kSideNames = {"below", "above"}; // in the order of Lumen::Side
const Keys kLineKeys = {"name", "count", "spacing", "points", "radius", "parent", "leavesAt"};
const Keys kKeyframeKeys = {"time",     "place", "easing", "camera", "look", "transferFunction",
                            "lighting", "cuts"};
const Keys kLookKeys = {"yaw", "pitch", "offset"};
const Keys kFlightKeys = {"route", "backwards", "from", "to", "speed", "viewAngle", "lookAhead", "clearance"};
constexpr double kMostMm = 1e7, kMostSeconds = 1e6;
constexpr int kMostIndex = 1000000;

glm::dvec3 placeOf(const JsonValue& value) {
    const JsonItems items = value.items();
    if (items.size() != 3)
        value.refuse("[x, y, z] in mm");
    return {items[0].number(-kMostMm, kMostMm), items[1].number(-kMostMm, kMostMm),
            items[2].number(-kMostMm, kMostMm)};
}
json listOf(const glm::dvec3& v) {
    return {v.x, v.y, v.z};
}

PathVolume parseVolume(const JsonValue& value) {
    value.requireKeys(kVolumeOfPathKeys);
    PathVolume volume;
    volume.contentHash = value.at("contentHash").text();
    const JsonItems size = value.at("size").items();
    if (size.size() != 3)
        value.at("size").refuse("[x, y, z] in voxels");
    for (int axis = 0; axis < 3; ++axis)
        volume.extentVoxels[axis] = size[static_cast<std::size_t>(axis)].integer(1, 1 << 30);
    return volume;
}

Lumen parseLumen(const JsonValue& value) {
    value.requireKeys(kLumenKeys);
    Lumen lumen{value.at("threshold").number(), value.at("side").oneOf(kSideNames) == kSideNames[0]
                                                    ? Lumen::Side::below
                                                    : Lumen::Side::above};
    if (value.has("noise"))
        lumen.noise = value.at("noise").number(0, 1e30);
    if (value.has("surface"))
        lumen.surface = value.at("surface").number();
    if (value.has("branchesTo"))
        lumen.branchesTo = value.at("branchesTo").number();
    if (value.has("branchWall"))
        lumen.branchWall = value.at("branchWall").number();
    if (value.has("leaks"))
        lumen.leaks = value.at("leaks").boolean();
    if (value.has("leavesAt"))
        lumen.leavesAtMm = value.at("leavesAt").number(0, kMostMm);
    if (value.has("unsure"))
        lumen.unsure = value.at("unsure").boolean();
    return lumen;
}

CentreLine parseLine(const JsonValue& value, std::size_t& points) {
    value.requireKeys(kLineKeys);
    CentreLine line;
    if (value.has("name"))
        line.name = value.at("name").text();
    line.spacingMm = value.at("spacing").number(1e-3, 1e4);
    for (const JsonValue& item : value.at("points").items())
        line.points.push_back(placeOf(item));
    for (const JsonValue& item : value.at("radius").items())
        line.radiusMm.push_back(item.number(0, kMostMm));
    const int count = value.at("count").integer(0, kMostIndex);
    if (static_cast<std::size_t>(count) != line.points.size())
        value.at("points").refuse("as many points as \"count\" says, " + std::to_string(count));
    points += line.points.size();
    if (points > Path::kMostPoints)
        value.at("points").refuse("at most " + std::to_string(Path::kMostPoints) + " points in all lines");
    if (value.has("parent"))
        line.parent = static_cast<std::size_t>(value.at("parent").integer(0, kMostIndex));
    if (value.has("parent") != value.has("leavesAt"))
        value.refuse("both \"parent\" and \"leavesAt\", or neither");
    if (line.parent)
        line.leavesAtMm = value.at("leavesAt").number(0, kMostMm);
    return line;
}

LookAround parseLook(const JsonValue& value) {
    value.requireKeys(kLookKeys);
    LookAround look;
    if (value.has("yaw"))
        look.yawDegrees = value.at("yaw").number(-360, 360);
    if (value.has("pitch"))
        look.pitchDegrees = value.at("pitch").number(-89, 89);
    if (value.has("offset")) {
        const JsonItems offset = value.at("offset").items();
        if (offset.size() != 2)
            value.at("offset").refuse("[right, up] in mm");
        look.offsetMm = {offset[0].number(-1e4, 1e4), offset[1].number(-1e4, 1e4)};
    }
    return look;
}

Keyframe parseKeyframe(const JsonValue& value) {
    value.requireKeys(kKeyframeKeys);
    Keyframe key;
    if (value.has("time"))
        key.timeS = value.at("time").number(0, kMostSeconds);
    if (value.has("place"))
        key.placeMm = value.at("place").number(0, kMostMm);
    if (value.has("easing"))
        key.easing = static_cast<Easing>(
            std::find(easingNames().begin(), easingNames().end(), value.at("easing").oneOf(easingNames())) -
            easingNames().begin());
    if (value.has("camera")) {
        value.at("camera").requireKeys(freeCameraKeys());
        key.camera = parseFreeCamera(value.at("camera"));
    }
    if (value.has("look"))
        key.look = parseLook(value.at("look"));
    if (value.has("transferFunction")) {
        const JsonValue function = value.at("transferFunction");
        if (function.isText()) {
            key.transferFunction = function.text();
        } else {
            if (!function.isObject())
                function.refuse("the name of a preset or an object");
            function.requireKeys(transferKeys());
            key.transferFunction = parseTransfer(function);
        }
    }
    if (value.has("lighting"))
        key.lighting = parseLighting(value.at("lighting"));
    if (value.has("cuts"))
        key.cuts = parseCuts(value.at("cuts"));
    return key;
}

Flight parseFlight(const JsonValue& value) {
    value.requireKeys(kFlightKeys);
    Flight flight;
    const auto read = [&](const char* key, double lowest, double highest, double& target) {
        if (value.has(key))
            target = value.at(key).number(lowest, highest);
    };
    if (value.has("route")) {
        flight.route.clear();
        for (const JsonValue& item : value.at("route").items())
            flight.route.push_back(static_cast<std::size_t>(item.integer(0, kMostIndex)));
    }
    if (value.has("backwards"))
        flight.backwards = value.at("backwards").boolean();
    read("from", 0, kMostMm, flight.fromMm);
    if (value.has("to"))
        flight.toMm = value.at("to").number(0, kMostMm);
    read("speed", 0.01, 1e5, flight.speedMmPerS);
    read("viewAngle", 1, Path::kMostViewAngle, flight.viewAngle);
    read("lookAhead", 0, 1e4, flight.lookAheadMm);
    read("clearance", 0, 1e4, flight.clearanceMm);
    return flight;
}

json lineJson(const CentreLine& line) {
    json points = json::array();
    for (const glm::dvec3& p : line.points)
        points.push_back(listOf(p));
    json out = {{"count", line.points.size()},
                {"spacing", line.spacingMm},
                {"points", std::move(points)},
                {"radius", line.radiusMm}};
    if (!line.name.empty())
        out["name"] = line.name;
    if (line.parent) {
        out["parent"] = *line.parent;
        out["leavesAt"] = line.leavesAtMm;
    }
    return out;
}

json keyframeJson(const Keyframe& key) {
    json out = {{"easing", easingNames()[static_cast<std::size_t>(key.easing)]}};
    if (key.timeS)
        out["time"] = *key.timeS;
    if (key.placeMm)
        out["place"] = *key.placeMm;
    if (key.camera)
        out["camera"] = freeCameraJson(*key.camera);
    if (key.look)
        out["look"] = {{"yaw", key.look->yawDegrees},
                       {"pitch", key.look->pitchDegrees},
                       {"offset", {key.look->offsetMm.x, key.look->offsetMm.y}}};
    if (key.transferFunction) {
        if (const auto* name = std::get_if<std::string>(&*key.transferFunction))
            out["transferFunction"] = *name;
        else
            out["transferFunction"] = transferJson(std::get<TransferFunction>(*key.transferFunction));
    }
    if (key.lighting) {
        json lighting = lightingJson(*key.lighting);
        out["lighting"] = lighting.is_null() ? json::object() : std::move(lighting);
    }
    if (key.cuts) {
        json cuts = cutsJson(*key.cuts);
        out["cuts"] = cuts.is_null() ? json::object() : std::move(cuts);
    }
    return out;
}

json flightJson(const Flight& flight) {
    json out = {{"route", flight.route},          {"backwards", flight.backwards},
                {"from", flight.fromMm},          {"speed", flight.speedMmPerS},
                {"viewAngle", flight.viewAngle},  {"lookAhead", flight.lookAheadMm},
                {"clearance", flight.clearanceMm}};
    if (flight.toMm)
        out["to"] = *flight.toMm;
    return out;
}

} // namespace

const std::vector<std::string>& easingNames() {
    static const Keys names = {"through", "smooth", "linear", "hold"};
    return names;
}

Path parsePath(const std::string& text, const std::string& where) {
    const json document = parseStrictJson(text, where);
    const JsonValue root(document, where);
    root.requireKeys(kPathKeys);
    root.at("tesseraPath").integer(Path::kVersion, Path::kVersion);
    Path path;
    if (root.has("volume"))
        path.volume = parseVolume(root.at("volume"));
    if (root.has("lumen"))
        path.lumen = parseLumen(root.at("lumen"));
    if (root.has("lines")) {
        std::size_t points = 0;
        for (const JsonValue& item : root.at("lines").items(Path::kMostLines, "lines"))
            path.lines.push_back(parseLine(item, points));
    }
    if (root.has("keyframes"))
        for (const JsonValue& item : root.at("keyframes").items(Path::kMostKeyframes, "keyframes"))
            path.keyframes.push_back(parseKeyframe(item));
    if (root.has("flight"))
        path.flight = parseFlight(root.at("flight"));
    if (root.has("framesPerSecond"))
        path.framesPerSecond = root.at("framesPerSecond").number(0.1, 1000);
    checkPath(path, where);
    return path;
}

Path loadPath(const std::filesystem::path& file) {
    return parsePath(readTextFile(file.string()), file.string());
}

std::string pathJson(const Path& path) {
    json document = {{"tesseraPath", Path::kVersion}, {"framesPerSecond", path.framesPerSecond}};
    if (path.volume)
        document["volume"] = {
            {"contentHash", path.volume->contentHash},
            {"size",
             {path.volume->extentVoxels.x, path.volume->extentVoxels.y, path.volume->extentVoxels.z}}};
    if (path.lumen) {
        json& lumen = document["lumen"] = {{"threshold", path.lumen->threshold},
                                           {"side", kSideNames[static_cast<std::size_t>(path.lumen->side)]}};
        if (path.lumen->noise > 0)
            lumen["noise"] = path.lumen->noise;
        if (path.lumen->surface)
            lumen["surface"] = *path.lumen->surface;
        if (path.lumen->branchesTo)
            lumen["branchesTo"] = *path.lumen->branchesTo;
        if (path.lumen->branchWall)
            lumen["branchWall"] = *path.lumen->branchWall;
        if (path.lumen->leaks)
            lumen["leaks"] = true;
        if (path.lumen->leavesAtMm)
            lumen["leavesAt"] = *path.lumen->leavesAtMm;
        if (path.lumen->unsure)
            lumen["unsure"] = true;
    }
    for (const CentreLine& line : path.lines)
        document["lines"].push_back(lineJson(line));
    for (const Keyframe& key : path.keyframes)
        document["keyframes"].push_back(keyframeJson(key));
    if (path.flight)
        document["flight"] = flightJson(*path.flight);
    return document.dump(-1, ' ', true, json::error_handler_t::replace);
}

std::map<std::string, std::vector<std::string>> pathKeys() {
    return {{"$", kPathKeys},         {"$.volume", kVolumeOfPathKeys},  {"$.lumen", kLumenKeys},
            {"$.lines[]", kLineKeys}, {"$.keyframes[]", kKeyframeKeys}, {"$.keyframes[].look", kLookKeys},
            {"$.flight", kFlightKeys}};
}

} // namespace tessera
