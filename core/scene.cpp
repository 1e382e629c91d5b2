// core/scene.cpp: see scene.h. Reading is strict: what is not understood is refused, because a scene that is
// read halfway draws a wrong picture.
#include "core/scene.h"

#include "core/colour.h"
#include "core/cuts_json.h"
#include "core/error.h"
#include "core/json_reader.h"
#include "core/lighting_json.h"
#include "core/measurement_json.h"
#include "core/nearest_name.h"
#include "core/shading_json.h"
#include "core/transfer_json.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace tessera {
namespace {

using nlohmann::json;
using Keys = std::vector<std::string>;

const Keys kSceneKeys = {"tesseraScene", "volumes",      "camera",  "shading",     "lighting",
                         "isosurfaces",  "mode",         "window",  "valueColour", "slice",
                         "cuts",         "measurements", "quality", "image"};
const Keys kSliceKeys = {"plane", "position", "point", "normal", "thickness", "reduction"};
const Keys kVolumeKeys = {"path", "transferFunction", "unit"};
const Keys kFittedKeys = {"view", "fit", "parallelProjection"};
const Keys kSurfaceKeys = {"value", "rgb", "opacity"};
const Keys kQualityKeys = {"stepVoxels", "integrator",   "fetch",    "terminationTransmittance",
                           "skipping",   "edgeFunction", "sampling", "maxError",
                           "samples",    "pixelFilter",  "seed"};
const Keys kImageKeys = {"size", "background"};

Keys cameraKeys() {
    Keys keys = kFittedKeys;
    for (const std::string& key : freeCameraKeys())
        if (std::find(keys.begin(), keys.end(), key) == keys.end())
            keys.push_back(key);
    return keys;
}

glm::dvec3 vector(const JsonValue& value) {
    const std::vector<double> n = value.numbers(3);
    return {n[0], n[1], n[2]};
}

/// Sets target when the key is there; a missing key keeps the default.
void readNumber(const JsonValue& object, const char* key, double lowest, double highest, double& target) {
    if (object.has(key))
        target = object.at(key).number(lowest, highest);
}
void readBoolean(const JsonValue& object, const char* key, bool& target) {
    if (object.has(key))
        target = object.at(key).boolean();
}

SceneVolume parseVolume(const JsonValue& value, const std::filesystem::path& folder) {
    value.requireKeys(kVolumeKeys);
    SceneVolume volume;
    const std::string path = value.at("path").text();
    if (path.empty())
        value.at("path").refuse("the path of a store or source");
    volume.path = std::filesystem::absolute(folder / path).lexically_normal();
    if (value.has("unit")) {
        value.at("unit").oneOf({"", "HU"});
        volume.unit = value.at("unit").text();
    }
    if (value.has("transferFunction")) {
        const JsonValue function = value.at("transferFunction");
        if (function.isText()) {
            volume.transferFunction = function.text();
        } else {
            if (!function.isObject())
                function.refuse("the name of a preset or an object");
            function.requireKeys(transferKeys());
            volume.transferFunction = parseTransfer(function);
        }
    }
    return volume;
}

CameraChoice parseCamera(const JsonValue& value) {
    value.requireKeys(cameraKeys());
    bool parallel = false;
    readBoolean(value, "parallelProjection", parallel);
    const Projection projection = parallel ? Projection::parallel : Projection::perspective;
    if (value.has("view")) {
        for (const std::string& key : freeCameraKeys())
            if (value.has(key) && key != "parallelProjection")
                throw badFile(value.place(), "either \"view\" or \"position\" and its companions",
                              "\"view\" and \"" + key + "\"");
        FittedView view{parseView(value.at("view").oneOf(viewNames()), value.place()), projection};
        if (value.has("fit"))
            view.fit = parseFit(value.at("fit").oneOf(fitNames()), value.place());
        view.named = true;
        return view;
    }
    if (value.has("fit"))
        throw badFile(value.place(), "\"view\" beside \"fit\"", "none");
    return parseFreeCamera(value);
}

Isosurface parseSurface(const JsonValue& value) {
    value.requireKeys(kSurfaceKeys);
    Isosurface surface;
    surface.value = value.at("value").number();
    readNumber(value, "opacity", 0, 1, surface.opacity);
    if (value.has("rgb")) {
        const JsonValue colour = value.at("rgb");
        if (colour.items().size() != 3)
            colour.refuse("[r, g, b], linear");
        for (int c = 0; c < 3; ++c)
            surface.colour[c] = colour.items()[static_cast<std::size_t>(c)].number(0, 1);
    }
    return surface;
}

std::vector<Isosurface> parseSurfaces(const JsonValue& value) {
    std::vector<Isosurface> surfaces;
    for (const JsonValue& item : value.items())
        surfaces.push_back(parseSurface(item));
    if (surfaces.size() > Scene::kMaxSurfaces)
        value.refuse("at most " + std::to_string(Scene::kMaxSurfaces) + " isosurfaces");
    return surfaces;
}

WindowChoice parseWindowJson(const JsonValue& value) {
    if (value.isText())
        return value.oneOf(windowNames());
    const std::vector<double> n = value.numbers(2);
    return checkedWindow(n[0], n[1], value.place());
}

SlicePlane parseSlice(const JsonValue& value) {
    value.requireKeys(kSliceKeys);
    SlicePlane slice;
    if (value.has("plane"))
        slice.orientation = parseOrientation(value.at("plane").oneOf(orientationNames()), value.place());
    const bool oblique = slice.orientation == Orientation::oblique;
    for (const char* key : {"position", "point", "normal"})
        if (value.has(key) && (std::string(key) == "position") == oblique)
            throw badFile(value.place(),
                          oblique ? "\"point\" and \"normal\" of an oblique plane" : "\"position\"",
                          std::string("\"") + key + "\"");
    if (value.has("position"))
        slice.positionMm = value.at("position").number();
    if (oblique) {
        slice.point = vector(value.at("point"));
        slice.normal = vector(value.at("normal"));
    }
    if (value.has("thickness"))
        slice.thicknessMm = value.at("thickness").number();
    if (value.has("reduction"))
        slice.reduction = parseReduction(value.at("reduction").oneOf(reductionNames()), value.place());
    checkSlice(slice, value.place());
    return slice;
}

json samplesJson(int samples) {
    return samples == PixelSampling::kAutomatic ? json("auto") : json(samples);
}

Quality parseQuality(const JsonValue& value) {
    value.requireKeys(kQualityKeys);
    Quality quality;
    quality.automaticStep = !value.has("stepVoxels");
    // 1/64 voxel: finer ones come near to what float positions along a ray can tell apart
    readNumber(value, "stepVoxels", 1.0 / 64, 16, quality.stepVoxels);
    if (value.has("integrator"))
        quality.integrator = parseIntegrator(value.at("integrator").oneOf(integratorNames()), value.place());
    if (value.has("fetch"))
        quality.fetch = parseFetch(value.at("fetch").oneOf(fetchNames()), value.place());
    if (value.has("edgeFunction"))
        quality.edgeFunction =
            parseEdgeFunction(value.at("edgeFunction").oneOf(edgeFunctionNames()), value.place());
    if (value.has("sampling"))
        quality.sampling = parseSampling(value.at("sampling").oneOf(samplingNames()), value.place());
    if (value.has("maxError")) {
        double maxError = 0;
        readNumber(value, "maxError", 0, 1000, maxError);
        quality.maxError = maxError;
    }
    readNumber(value, "terminationTransmittance", 0, 0.5, quality.terminationTransmittance);
    readBoolean(value, "skipping", quality.skipping);
    quality.pixels.named = value.has("samples");
    if (quality.pixels.named) {
        const JsonValue samples = value.at("samples");
        quality.pixels.samples = samples.isText() ? (samples.oneOf({"auto"}), PixelSampling::kAutomatic)
                                                  : samples.integer(1, PixelSampling::kMost);
    }
    if (value.has("pixelFilter"))
        quality.pixels.filter =
            parsePixelFilter(value.at("pixelFilter").oneOf(pixelFilterNames()), value.place());
    if (value.has("seed"))
        quality.pixels.seed =
            static_cast<std::uint32_t>(value.at("seed").integer(0, std::numeric_limits<int>::max()));
    return quality;
}

void parseImage(const JsonValue& value, Scene& scene) {
    value.requireKeys(kImageKeys);
    if (value.has("size")) {
        const std::vector<JsonValue> size = value.at("size").items();
        if (size.size() != 2)
            value.at("size").refuse("[width, height]");
        for (int axis = 0; axis < 2; ++axis)
            scene.imageSize[axis] = size[static_cast<std::size_t>(axis)].integer(1, Scene::kMaxImageExtent);
    }
    if (value.has("background")) {
        const JsonValue background = value.at("background");
        if (background.isList()) { // linear rgb: for colours that eight bits of sRGB cannot name
            glm::vec3 colour(0);
            if (background.items().size() != 3)
                background.refuse("[r, g, b], linear");
            for (int c = 0; c < 3; ++c)
                colour[c] = static_cast<float>(background.items()[static_cast<std::size_t>(c)].number(0, 1));
            scene.background = colour;
        } else {
            scene.background = parseBackground(background.text(), background.place());
        }
    }
}

json listOf(const glm::dvec3& v) {
    return {v.x, v.y, v.z};
}

json sliceJson(const SlicePlane& slice) {
    json out = {{"plane", orientationNames()[static_cast<std::size_t>(slice.orientation)]}};
    if (slice.orientation == Orientation::oblique) {
        out["point"] = listOf(slice.point);
        out["normal"] = listOf(slice.normal);
    } else if (slice.positionMm) {
        out["position"] = *slice.positionMm;
    }
    if (slice.thicknessMm > 0) {
        out["thickness"] = slice.thicknessMm;
        out["reduction"] = reductionNames()[static_cast<std::size_t>(slice.reduction) - 1];
    }
    return out;
}

json cameraJson(const CameraChoice& choice) {
    if (const auto* fitted = std::get_if<FittedView>(&choice))
        return {{"view", viewNames()[static_cast<std::size_t>(fitted->view)]},
                {"fit", fitNames()[static_cast<std::size_t>(fitted->fit)]},
                {"parallelProjection", fitted->projection == Projection::parallel}};
    return freeCameraJson(std::get<Camera>(choice));
}

json backgroundJson(const std::optional<glm::vec3>& background) {
    if (!background)
        return "transparent";
    std::array<char, 8> hex{};
    const auto byte = [&](int c) {
        return static_cast<unsigned>(
            std::lround(srgbFromLinear(static_cast<double>((*background)[c])) * 255));
    };
    std::snprintf(hex.data(), hex.size(), "#%02x%02x%02x", byte(0) & 255, byte(1) & 255, byte(2) & 255);
    if (parseBackground(hex.data(), "background") == background)
        return hex.data();
    return listOf(glm::dvec3(*background));
}

} // namespace

const std::vector<std::string>& viewNames() {
    static const Keys names = {"anterior", "posterior", "left", "right", "superior", "inferior"};
    return names;
}
const std::vector<std::string>& fitNames() {
    static const Keys names = {"shown", "volume"};
    return names;
}
const std::vector<std::string>& fetchNames() {
    static const Keys names = {"hardware", "exact"};
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
    static const std::vector<std::string> names = {"forward", "central", "sobel", "analytic", "central-half"};
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

double brightest(const Shading& shading, const Lighting& lighting, const std::vector<Material>& materials) {
    if (!shading.on)
        return 1;
    const double light = mostLight(lighting.lights);
    double most = std::max(1.0, shading.ambient + light * (shading.diffuse + shading.specular));
    for (const Material& m : materials)
        most = std::max(most, m.ambient + light * (m.diffuse + m.specular) +
                                  std::max({m.emission.r, m.emission.g, m.emission.b}));
    return most;
}

Reduction reductionOf(const Scene& scene) {
    switch (scene.mode) {
    case Mode::maximum:
        return Reduction::maximum;
    case Mode::minimum:
        return Reduction::minimum;
    case Mode::average:
        return Reduction::average;
    case Mode::slice:
        return scene.slice.thicknessMm > 0 ? scene.slice.reduction : Reduction::maximum;
    case Mode::composite:
    case Mode::isosurface:
        break;
    }
    return Reduction::composite;
}

Scene asDrawn(const Scene& scene) {
    Scene drawn = scene;
    if (scene.mode == Mode::isosurface) {
        if (std::none_of(scene.surfaces.begin(), scene.surfaces.end(),
                         [](const Isosurface& s) { return s.opacity > 0; }))
            throw InputError("mode isosurface: expected an isosurface that is not wholly transparent "
                             "(--isosurface VALUE), found none");
        return drawn;
    }
    if (reductionOf(scene) == Reduction::composite)
        return drawn;
    drawn.shading.on = false;
    drawn.lighting = {};
    drawn.surfaces.clear();
    drawn.quality.integrator = Integrator::midpoint;
    return drawn;
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
    if (text == "black")
        return glm::vec3(0);
    if (text == "white")
        return glm::vec3(1);
    const bool hex = text.size() == 7 && text[0] == '#' &&
                     text.find_first_not_of("0123456789abcdefABCDEF", 1) == std::string::npos;
    if (!hex)
        throw badFile(where, "black, white, #rrggbb or transparent", "\"" + text.substr(0, 40) + "\"");
    glm::vec3 linear(0);
    for (int c = 0; c < 3; ++c) {
        const int byte = std::stoi(text.substr(static_cast<std::size_t>(1 + 2 * c), 2), nullptr, 16);
        linear[c] = static_cast<float>(linearFromSrgb(byte / 255.0));
    }
    return linear;
}

bool isSceneFile(const std::filesystem::path& path) {
    std::error_code ignored;
    if (path.extension() != ".json" || !std::filesystem::is_regular_file(path, ignored))
        return false;
    const json document = json::parse(readTextFile(path.string()), nullptr, false);
    return document.is_discarded() || document.contains("tesseraScene") || document.contains("volumes") ||
           document.contains("camera");
}

Scene parseScene(const std::string& text, const std::filesystem::path& folder, const std::string& where) {
    const json document = parseStrictJson(text, where);
    const JsonValue root(document, where);
    root.requireKeys(kSceneKeys);
    root.at("tesseraScene").integer(Scene::kVersion, Scene::kVersion);
    Scene scene;
    const std::vector<JsonValue> volumes = root.at("volumes").items();
    if (volumes.size() != 1)
        root.at("volumes").refuse("a list of exactly one volume (more are not drawn yet)");
    scene.volumes.push_back(parseVolume(volumes.front(), folder));
    if (root.has("camera"))
        scene.camera = parseCamera(root.at("camera"));
    if (root.has("shading"))
        scene.shading = parseShading(root.at("shading"));
    if (root.has("lighting"))
        scene.lighting = parseLighting(root.at("lighting"));
    if (root.has("isosurfaces"))
        scene.surfaces = parseSurfaces(root.at("isosurfaces"));
    if (root.has("mode"))
        scene.mode = parseMode(root.at("mode").oneOf(modeNames()), root.at("mode").place());
    if (root.has("window"))
        scene.window = parseWindowJson(root.at("window"));
    if (root.has("valueColour"))
        scene.valueColour = parseValueColour(root.at("valueColour").oneOf(valueColourNames()),
                                             root.at("valueColour").place());
    if (root.has("slice"))
        scene.slice = parseSlice(root.at("slice"));
    if (root.has("cuts"))
        scene.cuts = parseCuts(root.at("cuts"));
    if (root.has("measurements"))
        scene.measurements = parseMeasurements(root.at("measurements"));
    scene.quality.automaticStep = true;
    if (root.has("quality"))
        scene.quality = parseQuality(root.at("quality"));
    if (root.has("image"))
        parseImage(root.at("image"), scene);
    return scene;
}

Scene loadScene(const std::filesystem::path& file) {
    return parseScene(readTextFile(file.string()), file.parent_path(), file.string());
}

std::string sceneJson(const Scene& scene) {
    json volumes = json::array();
    for (const SceneVolume& volume : scene.volumes) {
        json function;
        if (const auto* name = std::get_if<std::string>(&volume.transferFunction))
            function = *name;
        else
            function = transferJson(std::get<TransferFunction>(volume.transferFunction));
        volumes.push_back({{"path", volume.path.string()},
                           {"transferFunction", std::move(function)},
                           {"unit", volume.unit}});
    }
    json surfaces = json::array();
    for (const Isosurface& surface : scene.surfaces)
        surfaces.push_back(
            {{"value", surface.value}, {"rgb", listOf(surface.colour)}, {"opacity", surface.opacity}});
    const Shading& shading = scene.shading;
    const Quality& quality = scene.quality;
    json qualityObject = {
        {"integrator", integratorNames()[static_cast<std::size_t>(quality.integrator)]},
        {"fetch", fetchNames()[static_cast<std::size_t>(quality.fetch)]},
        {"terminationTransmittance", quality.terminationTransmittance},
        {"skipping", quality.skipping},
        {"edgeFunction", edgeFunctionNames()[static_cast<std::size_t>(quality.edgeFunction)]},
        {"sampling", samplingNames()[static_cast<std::size_t>(quality.sampling)]}};
    if (!quality.automaticStep)
        qualityObject["stepVoxels"] = quality.stepVoxels;
    if (quality.maxError)
        qualityObject["maxError"] = *quality.maxError;
    const PixelSampling plain, &pixels = quality.pixels;
    if (pixels.named || pixels.samples != plain.samples)
        qualityObject["samples"] = samplesJson(pixels.samples);
    if (pixels.filter != plain.filter)
        qualityObject["pixelFilter"] = pixelFilterNames()[static_cast<std::size_t>(pixels.filter)];
    if (pixels.seed != plain.seed)
        qualityObject["seed"] = pixels.seed;
    json document = {{"tesseraScene", Scene::kVersion},
                     {"volumes", std::move(volumes)},
                     {"camera", cameraJson(scene.camera)},
                     {"shading",
                      {{"shade", shading.on},
                       {"ambient", shading.ambient},
                       {"diffuse", shading.diffuse},
                       {"specular", shading.specular},
                       {"specularPower", shading.specularPower},
                       {"gradient", gradientNames()[static_cast<std::size_t>(shading.gradient)]}}},
                     {"isosurfaces", std::move(surfaces)},
                     {"quality", std::move(qualityObject)},
                     {"image",
                      {{"size", {scene.imageSize.x, scene.imageSize.y}},
                       {"background", backgroundJson(scene.background)}}}};
    if (const auto* view = std::get_if<FittedView>(&scene.camera);
        scene.mode == Mode::slice && view && !view->named)
        document.erase("camera");
    const Scene none;
    if (scene.mode != Mode::composite)
        document["mode"] = modeNames()[static_cast<std::size_t>(scene.mode)];
    if (scene.window != none.window) {
        if (const auto* window = std::get_if<GreyWindow>(&scene.window))
            document["window"] = {window->centre, window->width};
        else
            document["window"] = std::get<std::string>(scene.window);
    }
    if (scene.valueColour != ValueColour::window)
        document["valueColour"] = valueColourNames()[static_cast<std::size_t>(scene.valueColour)];
    if (scene.mode == Mode::slice || !(scene.slice == none.slice))
        document["slice"] = sliceJson(scene.slice);
    if (json cuts = cutsJson(scene.cuts); !cuts.is_null())
        document["cuts"] = std::move(cuts);
    if (!scene.measurements.empty())
        document["measurements"] = measurementsJson(scene.measurements);
    if (shading.model != ShadingModel::phong)
        document["shading"]["model"] = shadingModelNames()[static_cast<std::size_t>(shading.model)];
    if (shading.gradientWeight)
        document["shading"]["gradientWeight"] = {shading.gradientWeight->low, shading.gradientWeight->high};
    if (json lighting = lightingJson(scene.lighting); !lighting.is_null())
        document["lighting"] = std::move(lighting);
    return document.dump(-1, ' ', true, json::error_handler_t::replace);
}

std::map<std::string, std::vector<std::string>> sceneKeys() {
    return {{"$", kSceneKeys},
            {"$.volumes[]", kVolumeKeys},
            {"$.volumes[].transferFunction", transferKeys()},
            {"$.camera", cameraKeys()},
            {"$.volumes[].transferFunction.materials[]", materialKeys()},
            {"$.shading", shadingKeys()},
            {"$.measurements[]", measurementKeys()},
            {"$.lighting", lightingKeys()},
            {"$.lighting.lights[]", lightKeys()},
            {"$.lighting.occlusion", occlusionKeys()},
            {"$.lighting.surfaceOcclusion", surfaceOcclusionKeys()},
            {"$.isosurfaces[]", kSurfaceKeys},
            {"$.slice", kSliceKeys},
            {"$.cuts", cutsKeys()},
            {"$.cuts.boxes[]", cropBoxKeys()},
            {"$.cuts.planes[]", cutPlaneKeys()},
            {"$.cuts.scissors[]", scissorsKeys()},
            {"$.cuts.scissors[].camera", freeCameraKeys()},
            {"$.quality", kQualityKeys},
            {"$.image", kImageKeys}};
}

} // namespace tessera
