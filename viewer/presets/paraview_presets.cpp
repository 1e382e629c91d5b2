// viewer/presets/paraview_presets.cpp: see preset_files.h. A list of objects with "RGBPoints" (x, r, g,
// b,
// ...) and, where opacities were saved too, "Points" (x, opacity, midpoint, sharpness, ...).
#include "viewer/presets/preset_files.h"

#include "core/base/error.h"
#include "core/base/json_reader.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace tessera {
namespace {

using nlohmann::json;

/// The numbers of a list, in tuples.
std::vector<std::vector<double>> tuples(const JsonValue& list, std::size_t arity) {
    const JsonItems items = list.items(arity * kMostCurvePoints, "numbers");
    if (items.empty() || items.size() % arity != 0)
        list.refuse("numbers in groups of " + std::to_string(arity));
    std::vector<std::vector<double>> out(items.size() / arity);
    for (std::size_t i = 0; i < items.size(); ++i)
        out[i / arity].push_back(items[i].number());
    return out;
}

struct Space {
    ColourSpace space = ColourSpace::diverging; // ParaView's own, where a file does not say
    bool wraps = true;
};

Space spaceOf(const JsonValue& map) {
    if (!map.has("ColorSpace"))
        return {};
    static const std::vector<std::pair<std::string, Space>> spaces = {
        {"RGB", {ColourSpace::rgb, true}},
        {"HSV", {ColourSpace::hsv, true}},
        {"HsvNoWrap", {ColourSpace::hsv, false}},
        {"Lab", {ColourSpace::lab, true}},
        {"CIELAB", {ColourSpace::lab, true}},
        {"Diverging", {ColourSpace::diverging, true}},
        {"Lab/CIEDE2000", {ColourSpace::labCiede2000, true}},
        {"Step", {ColourSpace::step, true}}};
    std::vector<std::string> names;
    for (const auto& [name, space] : spaces)
        names.push_back(name);
    const std::string name = map.at("ColorSpace").oneOf(names);
    return std::find_if(spaces.begin(), spaces.end(), [&](const auto& s) { return s.first == name; })->second;
}

ForeignPreset readMap(const JsonValue& map) {
    std::vector<VtkColour> colours;
    for (const auto& t : tuples(map.at("RGBPoints"), 4))
        colours.push_back({t[0], {t[1], t[2], t[3]}});
    const auto byPlace = [](const auto& a, const auto& b) { return a.x < b.x; };
    double lowest = std::min_element(colours.begin(), colours.end(), byPlace)->x;
    double highest = std::max_element(colours.begin(), colours.end(), byPlace)->x;
    ForeignPreset out;
    std::vector<VtkPoint> opacity;
    if (map.has("Points")) {
        for (const auto& t : tuples(map.at("Points"), 4))
            opacity.push_back({t[0], t[1], t[2], t[3]});
        lowest = std::min(lowest, std::min_element(opacity.begin(), opacity.end(), byPlace)->x);
        highest = std::max(highest, std::max_element(opacity.begin(), opacity.end(), byPlace)->x);
    } else {
        opacity = {{lowest, 0}, {highest, 1}};
        out.leftOut.push_back("there are no opacities: a ramp from 0 to 1 replaces them");
    }
    out.preset.name = map.has("Name") ? map.at("Name").text() : "";
    out.preset.description =
        "From ParaView's colour map" + (out.preset.name.empty() ? "" : " " + out.preset.name) + ".";
    out.preset.unit = lowest == 0 && highest == 1 ? PresetUnit::share : PresetUnit::any;
    const Space space = spaceOf(map);
    out.preset.function = TransferFunction::fromOpacity(
        opacityPoints(opacity), colourPoints(colours, space.space, space.wraps), 1, map.place());
    return out;
}

} // namespace

std::vector<ForeignPreset> readParaView(const std::string& text, const std::string& where) {
    const json document = parseStrictJson(text, where);
    const JsonValue root(document, where);
    std::vector<ForeignPreset> out;
    if (root.isObject()) // one that was taken out of its list
        return {readMap(root)};
    std::size_t indexed = 0;
    for (const JsonValue& map : root.items())
        if (map.has("RGBPoints"))
            out.push_back(readMap(map));
        else
            ++indexed;
    if (out.empty())
        root.refuse("a colour map with \"RGBPoints\" (" + std::to_string(indexed) + " without)");
    return out;
}

ForeignText writeParaView(const Preset& preset) {
    const TransferFunction& f = preset.function;
    json colours = json::array(), points = json::array();
    for (const VtkColour& p : screenColours(f.colourPoints()))
        colours.insert(colours.end(), {p.x, p.colour.r, p.colour.g, p.colour.b});
    for (const VtkPoint& p : distinct(f.opacityPoints()))
        points.insert(points.end(), {p.x, p.y, p.midpoint, p.sharpness});
    if (colours.empty()) { // white
        const double lowest = f.kinks().empty() ? 0 : f.kinks().front();
        colours = {lowest, 1, 1, 1, f.kinks().empty() ? 1 : f.kinks().back(), 1, 1, 1};
    }
    const json map = {{"Name", preset.name.empty() ? "Tessera" : preset.name},
                      {"Creator", "Tessera"},
                      {"ColorSpace", "RGB"},
                      {"RGBPoints", colours},
                      {"Points", points},
                      {"NanColor", {1, 0, 0}}};
    ForeignText out{json::array({map}).dump(2, ' ', true, json::error_handler_t::replace) + "\n", {}};
    if (f.referenceLengthMm() != 1)
        out.leftOut.push_back("the unit distance of opacities (in ParaView, ScalarOpacityUnitDistance: " +
                              json(f.referenceLengthMm()).dump() + ")");
    if (!f.gradientOpacity().isOne())
        out.leftOut.push_back("gradient opacity");
    if (!f.materials().empty())
        out.leftOut.push_back("materials");
    if (!f.tissues().empty())
        out.leftOut.push_back("tissues");
    for (const std::string& key : lookSaysOf(preset))
        out.leftOut.push_back("\"" + key + "\"");
    return out;
}

} // namespace tessera
