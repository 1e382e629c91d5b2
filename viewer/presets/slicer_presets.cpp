// viewer/presets/slicer_presets.cpp: see preset_files.h. Slicer writes one thing in three ways: JSON
// (volume-property-schema v1.0.0), nine lines of text (.vp), and attributes of MRML elements whose names the
// lines have too. A function there is a count and as many numbers.
#include "viewer/presets/preset_files.h"

#include "core/base/error.h"
#include "core/base/json_reader.h"
#include "core/base/magnitude.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <vtkObject.h>
#include <vtkSmartPointer.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLUtilities.h>

namespace tessera {
namespace {

using nlohmann::json;

constexpr const char* kSchema = "https://raw.githubusercontent.com/slicer/slicer/main/Modules/Loadable/"
                                "VolumeRendering/Resources/Schema/volume-property-schema-v1.0.0.json#";
constexpr std::size_t kMostNumbers = 4 * kMostCurvePoints + 1; // and their count
constexpr double kLeastUnitMm = 1e-6, kMostUnitMm = 1e6;       // of scenes, as for specular powers below
constexpr double kMostPower = 1024;

/// A volume property, however it was written.
struct Property {
    std::string name;
    std::vector<VtkPoint> opacity, gradientOpacity;
    std::vector<VtkColour> colours;
    double unitMm = 1;
    bool shade = true, nearest = false, gradients = true; // gradients: gradientOpacity counts
    double ambient = 0.1, diffuse = 0.7, specular = 0.2, specularPower = 10; // vtkVolumeProperty's
};

/// VTK scales gradients by the mean of the volume's spacings.
/// @param isExact  false where points are left out
GradientOpacity gradientOpacityOf(std::vector<VtkPoint> curve, bool& isExact, const std::string& where) {
    constexpr std::size_t kMostRead = 256;
    if (curve.size() > kMostRead)
        throw badFile(where, "at most " + std::to_string(kMostRead) + " points of gradient opacity",
                      std::to_string(curve.size()));
    for (VtkPoint& point : curve)
        point.x = std::max(0.0, point.x);
    std::vector<OpacityPoint> points = opacityPoints(curve);
    for (double error = kOpacityError; points.size() > GradientOpacity::kMostPoints && error < 0.5;) {
        error *= 2;
        isExact = false;
        points = opacityPoints(curve, error);
    }
    isExact = thinned(points, GradientOpacity::kMostPoints) <= kOpacityError && isExact;
    std::vector<GradientPoint> out;
    for (const OpacityPoint& point : points)
        out.push_back({point.value, point.opacity});
    return GradientOpacity::fromPoints(std::move(out), GradientOpacity::Per::voxel);
}

ForeignPreset presetFrom(const Property& p, const std::string& where) {
    if (p.opacity.empty())
        throw badFile(where, "points of a scalar opacity", "none");
    ForeignPreset out;
    out.preset.name = p.name;
    out.preset.description = "From 3D Slicer's volume property" + (p.name.empty() ? "" : " " + p.name) + ".";
    out.preset.function = TransferFunction::fromOpacity(
        opacityPoints(p.opacity), colourPoints(p.colours, ColourSpace::rgb, false),
        std::clamp(p.unitMm, kLeastUnitMm, kMostUnitMm), where);
    const auto share = [](double x) { return std::clamp(x, 0.0, 1.0); };
    out.preset.look = json({{"shading",
                             {{"shade", p.shade},
                              {"ambient", share(p.ambient)},
                              {"diffuse", share(p.diffuse)},
                              {"specular", share(p.specular)},
                              {"specularPower", std::clamp(p.specularPower, 0.0, kMostPower)}}}})
                          .dump();
    if (p.gradients) {
        bool isExact = true;
        out.preset.function.setGradientOpacity(gradientOpacityOf(p.gradientOpacity, isExact, where));
        if (!isExact)
            out.leftOut.push_back("points of the gradient opacity beyond " +
                                  std::to_string(GradientOpacity::kMostPoints) +
                                  " (those that matter least)");
    }
    if (p.nearest)
        out.leftOut.push_back("values of the nearest voxel (they are interpolated)");
    return out;
}

/// Reads "COUNT number number ...", in tuples of `arity`.
std::vector<std::vector<double>> tuples(const std::string& text, std::size_t arity,
                                        const std::string& where) {
    const std::string expected = "a count and as many numbers, in groups of " + std::to_string(arity);
    std::vector<double> numbers;
    const char* at = text.c_str();
    for (;;) {
        char* end = nullptr;
        const double number = std::strtod(at, &end);
        if (end == at)
            break;
        if (!std::isfinite(number))
            throw badFile(where, "finite numbers", std::string(at, static_cast<const char*>(end)));
        numbers.push_back(number);
        at = end;
        if (numbers.size() > kMostNumbers)
            throw badFile(where, "at most " + std::to_string(kMostNumbers) + " numbers", "more");
    }
    if (const std::string rest(at); rest.find_first_not_of(" \t\r\n") != std::string::npos)
        throw badFile(where, expected, "\"" + rest.substr(0, 40) + "\"");
    if (numbers.empty() || numbers.front() != static_cast<double>(numbers.size() - 1) ||
        (numbers.size() - 1) % arity != 0)
        throw badFile(where, expected,
                      numbers.empty() ? "none"
                                      : std::to_string(numbers.size() - 1) + " numbers after the count " +
                                            shownNumber(numbers.front()));
    std::vector<std::vector<double>> out;
    for (std::size_t i = 1; i < numbers.size(); i += arity)
        out.emplace_back(numbers.begin() + static_cast<std::ptrdiff_t>(i),
                         numbers.begin() + static_cast<std::ptrdiff_t>(i + arity));
    return out;
}

std::vector<VtkPoint> curveOf(const std::string& text, const std::string& where) {
    std::vector<VtkPoint> out;
    for (const auto& t : tuples(text, 2, where))
        out.push_back({t[0], t[1]});
    return out;
}

std::vector<VtkColour> coloursOf(const std::string& text, const std::string& where) {
    std::vector<VtkColour> out;
    for (const auto& t : tuples(text, 4, where))
        out.push_back({t[0], {t[1], t[2], t[3]}});
    return out;
}

double numberOf(const std::string& text, const std::string& where) {
    char* end = nullptr;
    const double number = std::strtod(text.c_str(), &end);
    if (end == text.c_str() || !std::isfinite(number))
        throw badFile(where, "a number", "\"" + text.substr(0, 40) + "\"");
    return number;
}

/// A property by the names that MRML and .vp have for its parts; none where it is not there.
Property propertyOf(const std::function<std::optional<std::string>(const char*)>& textOf,
                    const std::string& where) {
    Property p;
    const auto place = [&](const char* key) { return where + ": " + key; };
    const auto number = [&](const char* key, double& into) {
        if (const auto text = textOf(key))
            into = numberOf(*text, place(key));
    };
    double interpolation = 1, shade = 1;
    number("interpolation", interpolation);
    number("shade", shade);
    p.nearest = interpolation == 0;
    p.shade = shade != 0;
    number("ambient", p.ambient);
    number("diffuse", p.diffuse);
    number("specular", p.specular);
    number("specularPower", p.specularPower);
    number("scalarOpacityUnitDistance", p.unitMm);
    if (const auto text = textOf("scalarOpacity"))
        p.opacity = curveOf(*text, place("scalarOpacity"));
    if (const auto text = textOf("gradientOpacity"))
        p.gradientOpacity = curveOf(*text, place("gradientOpacity"));
    if (const auto text = textOf("colorTransfer"))
        p.colours = coloursOf(*text, place("colorTransfer"));
    return p;
}

void findElements(vtkXMLDataElement* element, std::vector<vtkXMLDataElement*>& found, int depth) {
    constexpr int kDeepest = 64;
    if (depth > kDeepest)
        return;
    if (const std::string name = element->GetName() ? element->GetName() : "";
        name == "VolumeProperty" || name == "VolumePropertyNode")
        found.push_back(element);
    for (int i = 0; i < element->GetNumberOfNestedElements(); ++i)
        findElements(element->GetNestedElement(i), found, depth + 1);
}

std::vector<VtkPoint> jsonCurve(const JsonValue& value) {
    std::vector<VtkPoint> out;
    for (const JsonValue& point : value.at("points").items(kMostCurvePoints, "points"))
        out.push_back({point.at("x").number(), point.at("y").number(),
                       point.has("midpoint") ? point.at("midpoint").number() : 0.5,
                       point.has("sharpness") ? point.at("sharpness").number() : 0});
    return out;
}

Property jsonProperty(const JsonValue& value) {
    const JsonItems components = value.at("components").items();
    if (components.size() != 1)
        value.at("components").refuse("a list of one component");
    const JsonValue& component = components.front();
    Property p;
    if (value.has("interpolationType"))
        p.nearest = value.at("interpolationType").text() == "nearest";
    const auto number = [](const JsonValue& object, const char* key, double& into) {
        if (object.has(key))
            into = object.at(key).number();
    };
    if (component.has("shade"))
        p.shade = component.at("shade").boolean();
    if (component.has("lighting")) {
        const JsonValue light = component.at("lighting");
        number(light, "ambient", p.ambient);
        number(light, "diffuse", p.diffuse);
        number(light, "specular", p.specular);
        number(light, "specularPower", p.specularPower);
    }
    number(component, "scalarOpacityUnitDistance", p.unitMm);
    if (component.has("disableGradientOpacity"))
        p.gradients = !component.at("disableGradientOpacity").boolean();
    p.opacity = jsonCurve(component.at("scalarOpacity"));
    if (component.has("gradientOpacity"))
        p.gradientOpacity = jsonCurve(component.at("gradientOpacity"));
    if (component.has("rgbTransferFunction"))
        for (const JsonValue& point :
             component.at("rgbTransferFunction").at("points").items(kMostCurvePoints, "points")) {
            const std::vector<double> c = point.at("color").numbers(3);
            p.colours.push_back({point.at("x").number(),
                                 {c[0], c[1], c[2]},
                                 point.has("midpoint") ? point.at("midpoint").number() : 0.5,
                                 point.has("sharpness") ? point.at("sharpness").number() : 0});
        }
    return p;
}

} // namespace

std::vector<ForeignPreset> readSlicerJson(const std::string& text, const std::string& where) {
    const json document = parseStrictJson(text, where);
    const JsonValue root(document, where);
    std::vector<ForeignPreset> out;
    for (const JsonValue& value : root.at("volumeProperties").items())
        out.push_back(presetFrom(jsonProperty(value), value.place()));
    if (out.empty())
        root.at("volumeProperties").refuse("a list of at least one volume property");
    return out;
}

std::vector<ForeignPreset> readSlicerText(const std::string& text, const std::string& where) {
    static const std::vector<std::string> names = {"interpolation", "shade",           "diffuse",
                                                   "ambient",       "specular",        "specularPower",
                                                   "scalarOpacity", "gradientOpacity", "colorTransfer"};
    std::vector<std::string> lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line) && lines.size() <= names.size();)
        if (line.find_first_not_of(" \t\r") != std::string::npos)
            lines.push_back(line);
    if (lines.size() != names.size())
        throw badFile(where, "the nine lines of a volume property", std::to_string(lines.size()) + " lines");
    return {presetFrom(propertyOf(
                           [&](const char* key) -> std::optional<std::string> {
                               const auto at = std::find(names.begin(), names.end(), key);
                               if (at == names.end())
                                   return std::nullopt;
                               return lines[static_cast<std::size_t>(at - names.begin())];
                           },
                           where),
                       where)};
}

std::vector<ForeignPreset> readSlicerXml(const std::string& text, const std::string& where) {
    const bool wasLoud = vtkObject::GetGlobalWarningDisplay() != 0; // errors are reported below
    vtkObject::GlobalWarningDisplayOff();
    const auto root =
        vtkSmartPointer<vtkXMLDataElement>::Take(vtkXMLUtilities::ReadElementFromString(text.c_str()));
    vtkObject::SetGlobalWarningDisplay(wasLoud);
    if (!root)
        throw badFile(where, "an XML document", "one that ends early or is not well-formed");
    std::vector<vtkXMLDataElement*> elements;
    findElements(root, elements, 0);
    std::vector<ForeignPreset> out;
    for (vtkXMLDataElement* element : elements) {
        if (!element->GetAttribute("scalarOpacity"))
            continue; // in a file of its own
        const char* const name = element->GetAttribute("name");
        Property p = propertyOf(
            [&](const char* key) -> std::optional<std::string> {
                const char* const value = element->GetAttribute(key);
                return value ? std::optional<std::string>(value) : std::nullopt;
            },
            where + (name ? std::string(": ") + name : ""));
        p.name = name ? name : "";
        out.push_back(presetFrom(p, where));
    }
    if (out.empty())
        throw badFile(where, "a VolumeProperty with a scalarOpacity",
                      std::to_string(elements.size()) + " of them, none with one");
    return out;
}

ForeignText writeSlicerJson(const Preset& preset) {
    const json look = json::parse(preset.look);
    const TransferFunction& f = preset.function;
    json opacity = json::array(), colours = json::array();
    for (const VtkPoint& p : distinct(f.opacityPoints()))
        opacity.push_back({{"x", p.x}, {"y", p.y}, {"midpoint", p.midpoint}, {"sharpness", p.sharpness}});
    for (const VtkColour& p : screenColours(f.colourPoints()))
        colours.push_back({{"x", p.x},
                           {"color", {p.colour.r, p.colour.g, p.colour.b}},
                           {"midpoint", p.midpoint},
                           {"sharpness", p.sharpness}});
    double lowest = 0, highest = 1;
    if (!f.kinks().empty())
        lowest = f.kinks().front(), highest = f.kinks().back();
    const Shading plain;
    const json shading = look.value("shading", json::object());
    const GradientOpacity& graded = f.gradientOpacity();
    std::vector<OpacityPoint> lengths = {{0, 1}};
    if (!graded.isOne())
        lengths.clear();
    for (const GradientPoint& p : graded.points())
        lengths.push_back({p.length, p.factor});
    json gradients = json::array();
    for (const VtkPoint& p : distinct(lengths))
        gradients.push_back({{"x", p.x}, {"y", p.y}, {"midpoint", p.midpoint}, {"sharpness", p.sharpness}});
    json component = {{"componentWeight", 1.0},
                      {"shade", shading.value("shade", plain.on)},
                      {"lighting",
                       {{"ambient", shading.value("ambient", plain.ambient)},
                        {"diffuse", shading.value("diffuse", plain.diffuse)},
                        {"specular", shading.value("specular", plain.specular)},
                        {"specularPower", shading.value("specularPower", plain.specularPower)}}},
                      {"disableGradientOpacity", graded.isOne()},
                      {"scalarOpacityUnitDistance", f.referenceLengthMm()},
                      {"rgbTransferFunction", {{"type", "colorTransferFunction"}, {"points", colours}}},
                      {"scalarOpacity", {{"type", "piecewiseLinearFunction"}, {"points", opacity}}},
                      {"gradientOpacity", {{"type", "piecewiseLinearFunction"}, {"points", gradients}}}};
    const json document = {{"@schema", kSchema},
                           {"volumeProperties",
                            {{{"effectiveRange", {lowest, highest}},
                              {"interpolationType", "linear"},
                              {"components", json::array({component})}}}}};
    ForeignText out{document.dump(2, ' ', true, json::error_handler_t::replace) + "\n", {}};
    if (!graded.isOne() && graded.per() == GradientOpacity::Per::mm)
        out.leftOut.push_back("that the gradient opacity is per mm (there it is per voxel)");
    if (!f.materials().empty())
        out.leftOut.push_back("materials");
    if (!f.tissues().empty())
        out.leftOut.push_back("tissues");
    for (const std::string& key : lookSaysOf(preset))
        if (key != "shading")
            out.leftOut.push_back("\"" + key + "\"");
    return out;
}

} // namespace tessera
