// core/scene/scene_reader.cpp: the part of scene.h that reads scenes from JSON. Strict: what is not
// understood is refused, because a scene that is read halfway draws a wrong picture.
#include "core/base/error.h"
#include "core/base/json_reader.h"
#include "core/base/magnitude.h"
#include "core/scene/cuts_json.h"
#include "core/scene/lighting_json.h"
#include "core/scene/measurement_json.h"
#include "core/scene/scene.h"
#include "core/scene/shading_json.h"
#include "core/scene/transfer_json.h"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

namespace tessera {
namespace {

using nlohmann::json;
using Keys = std::vector<std::string>;

const Keys kSceneKeys = {"tesseraScene", "volumes",      "camera",  "shading",     "lighting",
                         "isosurfaces",  "mode",         "window",  "valueColour", "slice",
                         "cuts",         "measurements", "quality", "image"};
const Keys kSliceKeys = {"plane", "position", "point", "normal", "thickness", "reduction"};
const Keys kVolumeKeys = {"path",  "transferFunction", "unit",      "series",
                          "phase", "largest",          "resampleZ", "allowMissing"};
const Keys kFittedKeys = {"view", "fit", "parallelProjection", "mmPerPixel"};
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
    SourceChoice& source = volume.source;
    for (const auto& [key, number] : {std::pair{"series", &source.series}, {"phase", &source.phase}})
        if (value.has(key))
            *number = value.at(key).integer(1, std::numeric_limits<int>::max());
    value.read("largest", source.largest);
    value.read("resampleZ", source.resampleZ);
    value.read("allowMissing", source.allowMissing);
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
    value.read("parallelProjection", parallel);
    const Projection projection = parallel ? Projection::parallel : Projection::perspective;
    double mmPerPixel = 0;
    value.read("mmPerPixel", kLeastMmPerPixel, kMostMmPerPixel, mmPerPixel);
    if (mmPerPixel > 0 && !parallel)
        throw badFile(value.place(), "\"parallelProjection\": true beside \"mmPerPixel\"", "perspective");
    if (value.has("view")) {
        for (const std::string& key : freeCameraKeys())
            if (value.has(key) && key != "parallelProjection")
                throw badFile(value.place(), "either \"view\" or \"position\" and its companions",
                              "\"view\" and \"" + key + "\"");
        FittedView view{View::anterior, projection};
        if (const JsonValue side = value.at("view"); side.isList()) {
            const std::vector<double> n = side.numbers(2);
            view.angles = checkedAngles(n[0], n[1], side.place());
        } else {
            view.view = parseView(side.oneOf(viewNames()), value.place());
        }
        view.mmPerPixel = mmPerPixel;
        if (value.has("fit"))
            view.fit = parseFit(value.at("fit").oneOf(fitNames()), value.place());
        view.named = true;
        return view;
    }
    if (value.has("fit"))
        throw badFile(value.place(), "\"view\" beside \"fit\"", "none");
    if (mmPerPixel > 0) { // of a slice that is looked at along its normal
        for (const std::string& key : freeCameraKeys())
            if (value.has(key) && key != "parallelProjection")
                throw badFile(value.place(), "\"view\" beside \"mmPerPixel\"", "\"" + key + "\"");
        FittedView view{View::anterior, projection};
        view.mmPerPixel = mmPerPixel;
        return view;
    }
    return parseFreeCamera(value);
}

Isosurface parseSurface(const JsonValue& value) {
    value.requireKeys(kSurfaceKeys);
    Isosurface surface;
    surface.value = value.at("value").number();
    checkValue(surface.value, "a value", value.at("value").place());
    value.read("opacity", 0, 1, surface.opacity);
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
    for (const JsonValue& item : value.items(Scene::kMaxSurfaces, "isosurfaces"))
        surfaces.push_back(parseSurface(item));
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

Quality parseQuality(const JsonValue& value) {
    value.requireKeys(kQualityKeys);
    Quality quality;
    quality.automaticStep = !value.has("stepVoxels");
    // 1/64 voxel: finer ones come near to what float positions along a ray can tell apart
    value.read("stepVoxels", 1.0 / 64, 16, quality.stepVoxels);
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
        value.read("maxError", 0, 1000, maxError);
        quality.maxError = maxError;
    }
    value.read("terminationTransmittance", 0, 0.5, quality.terminationTransmittance);
    value.read("skipping", quality.skipping);
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
        const JsonItems size = value.at("size").items();
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

} // namespace

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
    const JsonItems volumes = root.at("volumes").items();
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
