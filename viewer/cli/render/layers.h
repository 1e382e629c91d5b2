// viewer/cli/render/layers.h: `--layers`: which layers a picture's file has besides its colour, and their
// channels (docs/sampling.md, "Layers").
#pragma once

#include "core/scene/scene.h"
#include "render/renderer.h"

#include <string>
#include <vector>

namespace tessera {

struct RenderArguments;

/// albedo, normal, depth, error
std::vector<std::string> layerNames();

struct LayerChoice {
    bool albedo = false, normal = false, depth = false, error = false;

    bool ofPaths() const { return albedo || normal || depth; }
    bool any() const { return ofPaths() || error; }
    std::vector<std::string> names() const;
};

/// What --layers asks for; `all`: what such a scene has. The scene then has no background, so that its alpha
/// is the picture's. Throws InputError naming the option for unknown layers, those that the scene has not,
/// pictures that hold none, and backgrounds that were asked for.
/// @param scene  with the options applied
LayerChoice layersOf(const RenderArguments& arguments, Scene& scene);

/// The channels of a picture's file. They refer to the result. Throws InputError naming the option where a
/// layer was not drawn.
std::vector<LayerChannel> channelsOf(const LayerChoice& layers, const RenderResult& result);

} // namespace tessera
