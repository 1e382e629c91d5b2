// core/scene/scene_writer.cpp: the part of scene.h that writes scenes as JSON, such that scene_reader.cpp
// reads the same scene.
#include "core/image/colour.h"
#include "core/scene/cuts_json.h"
#include "core/scene/lighting_json.h"
#include "core/scene/measurement_json.h"
#include "core/scene/scene.h"
#include "core/scene/transfer_json.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>

namespace tessera {
namespace {

using nlohmann::json;

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
    if (const auto* fitted = std::get_if<FittedView>(&choice)) {
        json out = {{"view", viewNames()[static_cast<std::size_t>(fitted->view)]},
                    {"fit", fitNames()[static_cast<std::size_t>(fitted->fit)]},
                    {"parallelProjection", fitted->projection == Projection::parallel}};
        if (fitted->angles)
            out["view"] = {fitted->angles->turn, fitted->angles->rise};
        if (fitted->mmPerPixel > 0)
            out["mmPerPixel"] = fitted->mmPerPixel;
        return out;
    }
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

json samplesJson(int samples) {
    return samples == PixelSampling::kAutomatic ? json("auto") : json(samples);
}

} // namespace

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
        // Told only where something was chosen: a store has nothing to choose.
        json& written = volumes.back();
        const SourceChoice& source = volume.source;
        for (const auto& [key, number] : {std::pair{"series", source.series}, {"phase", source.phase}})
            if (number > 0)
                written[key] = number;
        for (const auto& [key, chosen] : {std::pair{"largest", source.largest},
                                          {"resampleZ", source.resampleZ},
                                          {"allowMissing", source.allowMissing}})
            if (chosen)
                written[key] = true;
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
        scene.mode == Mode::slice && view && !view->named) {
        document.erase("camera");
        if (view->mmPerPixel > 0)
            document["camera"] = {{"parallelProjection", true}, {"mmPerPixel", view->mmPerPixel}};
    }
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

} // namespace tessera
