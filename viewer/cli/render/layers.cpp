// viewer/cli/render/layers.cpp: see layers.h.
#include "viewer/cli/render/layers.h"

#include "core/base/error.h"
#include "core/base/names.h"
#include "core/image/page_format.h"
#include "viewer/cli/render/scene_from_arguments.h"

#include <algorithm>
#include <array>
#include <sstream>
#include <utility>

namespace tessera {
namespace {

constexpr const char* kLayersOption = "--layers";
constexpr std::array<std::pair<const char*, bool LayerChoice::*>, 4> kLayers = {
    {{"albedo", &LayerChoice::albedo},
     {"normal", &LayerChoice::normal},
     {"depth", &LayerChoice::depth},
     {"error", &LayerChoice::error}}};

/// Why a scene has no standard errors of pixels; empty: it has.
std::string withoutErrors(const Scene& scene) {
    const int samples = scene.quality.pixels.samples;
    return samples == PixelSampling::kAutomatic ? "auto, which tells none" : samples == 1 ? "1" : "";
}

void requireLayers(const LayerChoice& layers, const Scene& scene) {
    if (layers.ofPaths() && (!scene.lighting.transport || reductionOf(scene) != Reduction::composite))
        throw badFile(
            kLayersOption,
            "paths of light (--light cinematic, or lighting.transport) for albedo, normal and depth",
            "a scene without");
    if (const std::string samples = withoutErrors(scene); layers.error && !samples.empty())
        throw badFile(kLayersOption, "a number of samples from 2 on (--samples) for error", samples);
}

} // namespace

std::vector<std::string> layerNames() {
    std::vector<std::string> names;
    for (const auto& [name, member] : kLayers)
        names.emplace_back(name);
    return names;
}

std::vector<std::string> LayerChoice::names() const {
    std::vector<std::string> names;
    for (const auto& [name, member] : kLayers)
        if (this->*member)
            names.emplace_back(name);
    return names;
}

LayerChoice layersOf(const RenderArguments& arguments, Scene& scene) {
    LayerChoice layers;
    if (arguments.layers.empty())
        return layers;
    if (arguments.isFilm() || !arguments.pathPicture().empty())
        throw badFile(kLayersOption, "one picture", arguments.isFilm() ? "a film" : arguments.pathPicture());
    if (pageFormat(arguments.out) || pictureFormat(arguments.out) != PictureFormat::exr)
        throw badFile(kLayersOption, "a picture .exr, which holds layers (-o)", arguments.out);
    for (const std::string& list : arguments.layers) {
        std::istringstream words(list);
        for (std::string word; std::getline(words, word, ',');) {
            const auto known = std::find_if(kLayers.begin(), kLayers.end(),
                                            [&](const auto& layer) { return word == layer.first; });
            if (known != kLayers.end()) {
                layers.*(known->second) = true;
            } else if (word == "all") {
                layers.albedo = layers.normal = layers.depth = scene.lighting.transport.has_value();
                layers.error = layers.error || withoutErrors(scene).empty();
            } else {
                throw badFile(kLayersOption, joinNames(layerNames()) + ", or all",
                              "\"" + word.substr(0, 40) + "\"");
            }
        }
    }
    if (!layers.any())
        throw badFile(kLayersOption,
                      "paths of light (--light cinematic) or a number of samples from 2 on (--samples)",
                      "a scene without layers besides its colour");
    requireLayers(layers, scene);
    if (arguments.keys.says("image.background") && scene.background)
        throw badFile("--background",
                      "transparent beside --layers, which leaves the background to compositing", "a colour");
    scene.background.reset();
    return layers;
}

std::vector<LayerChannel> channelsOf(const LayerChoice& layers, const RenderResult& result) {
    std::vector<LayerChannel> channels;
    const auto add = [&](const char* layer, const Image& image, const char* names, int from) {
        for (int c = 0; names[c] != '\0'; ++c)
            channels.push_back({std::string(layer) + "." + names[c], &image.pixels[0][from + c], 4});
    };
    if (layers.ofPaths() && !result.layers)
        throw badFile(kLayersOption, "a picture with paths of light", "one without");
    if (layers.error && !result.pixelErrors)
        throw badFile(kLayersOption, "a picture whose pixels have several samples, for error", "one without");
    if (layers.albedo)
        add("albedo", result.layers->albedo, "RGB", 0);
    if (layers.normal)
        add("normal", result.layers->normal, "XYZ", 0);
    if (layers.depth)
        add("depth", result.layers->normal, "Z", 3);
    if (layers.error)
        add("error", *result.pixelErrors, "RGBA", 0);
    return channels;
}

} // namespace tessera
