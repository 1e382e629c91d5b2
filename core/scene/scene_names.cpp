// core/scene/scene_names.cpp: words of scenes and options: the part of scene.h that spells and understands
// them.
#include "core/base/error.h"
#include "core/base/nearest_name.h"
#include "core/image/colour.h"
#include "core/scene/scene.h"

#include <cmath>

namespace tessera {

const std::vector<std::string>& viewNames() {
    static const std::vector<std::string> names = {"anterior", "posterior", "left",
                                                   "right",    "superior",  "inferior"};
    return names;
}
const std::vector<std::string>& fitNames() {
    static const std::vector<std::string> names = {"shown", "volume", "kept"};
    return names;
}
const std::vector<std::string>& fetchNames() {
    static const std::vector<std::string> names = {"hardware", "exact"};
    return names;
}

const std::vector<std::string>& edgeFunctionNames() {
    static const std::vector<std::string> names = {"nearest", "minimum", "split", "maximum"};
    return names;
}

const std::vector<std::string>& samplingNames() {
    static const std::vector<std::string> names = {"full", "limited", "naive"};
    return names;
}

const std::vector<std::string>& integratorNames() {
    static const std::vector<std::string> names = {"auto", "midpoint", "linear", "pre-integrated",
                                                   "pre-integrated-2d"};
    return names;
}
const std::vector<std::string>& gradientNames() {
    static const std::vector<std::string> names = {"forward",  "central",      "sobel",
                                                   "analytic", "central-half", "cubic"};
    return names;
}

const std::vector<std::string>& pixelFilterNames() {
    static const std::vector<std::string> names = {"box", "gaussian"};
    return names;
}

const std::vector<std::string>& shadingModelNames() {
    static const std::vector<std::string> names = {"phong", "blinn-phong"};
    return names;
}

View parseView(const std::string& text, const std::string& where) {
    static const std::map<std::string, View> others = {
        {"front", View::anterior},   {"ventral", View::anterior}, {"back", View::posterior},
        {"dorsal", View::posterior}, {"top", View::superior},     {"cranial", View::superior},
        {"bottom", View::inferior},  {"caudal", View::inferior}};
    if (const auto other = others.find(text); other != others.end())
        return other->second;
    return static_cast<View>(indexOfName(text, viewNames(), where));
}
ViewAngles checkedAngles(double turn, double rise, const std::string& where) {
    if (!(std::abs(turn) <= 360 && std::abs(rise) <= 90))
        throw badFile(where, "degrees about the patient's axis, from -360 to 360, and up, from -90 to 90",
                      std::to_string(turn) + "," + std::to_string(rise));
    return {turn, rise};
}
ViewAxes axesOf(const FittedView& view) {
    if (view.axes)
        return *view.axes;
    return view.angles ? viewAxes(*view.angles) : viewAxes(view.view);
}
Fit parseFit(const std::string& text, const std::string& where) {
    return static_cast<Fit>(indexOfName(text, fitNames(), where));
}
Fetch parseFetch(const std::string& text, const std::string& where) {
    return static_cast<Fetch>(indexOfName(text, fetchNames(), where));
}

EdgeFunction parseEdgeFunction(const std::string& text, const std::string& where) {
    return static_cast<EdgeFunction>(indexOfName(text, edgeFunctionNames(), where));
}

PixelFilter parsePixelFilter(const std::string& text, const std::string& where) {
    return static_cast<PixelFilter>(indexOfName(text, pixelFilterNames(), where));
}

Sampling parseSampling(const std::string& text, const std::string& where) {
    return static_cast<Sampling>(indexOfName(text, samplingNames(), where));
}

Integrator parseIntegrator(const std::string& text, const std::string& where) {
    return static_cast<Integrator>(indexOfName(text, integratorNames(), where));
}

Gradient parseGradient(const std::string& text, const std::string& where) {
    return static_cast<Gradient>(indexOfName(text, gradientNames(), where));
}

std::optional<glm::vec3> parseBackground(const std::string& text, const std::string& where) {
    if (text == "transparent")
        return std::nullopt;
    return parseColour(text, where, "transparent, ");
}

glm::vec3 parseColour(const std::string& text, const std::string& where, const std::string& others) {
    const std::optional<glm::vec3> colour = findColour(text);
    if (!colour)
        throw badFile(where,
                      others + "#rrggbb or a colour's name (black, white, red, grey and the others of CSS)",
                      "\"" + text.substr(0, 40) + "\"; nearest: \"" + nearestColour(text) + "\"");
    return *colour;
}

} // namespace tessera
