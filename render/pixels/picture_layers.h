// render/pixels/picture_layers.h: layers of a picture besides its colour (docs/sampling.md, "Layers"): what
// paths of light find where they begin. Means over a pixel's samples, as its colour is.
#pragma once

#include "core/image/image.h"
#include "render/plan/frame_plan.h"
#include "render/transport/path_beginning.h"

#include <array>
#include <cstddef>
#include <span>

namespace tessera {

/// What a caller wants besides the colour; what it does not want is neither computed nor kept.
struct LayersAsked {
    bool paths = false;  // PictureLayers; of scenes with a transport
    bool errors = false; // the standard error of every pixel's mean; of pixels with several samples
};

struct PictureLayers {
    Image albedo; // premultiplied by the samples' opacity, as colours are; a: the opacity of those samples
    Image normal; // likewise, patient space; a: their depth, mm, weighted by opacity and divided by it

    /// Sums of samples in both pictures: albedo, and normal and depth, each times the sample's opacity.
    static constexpr std::size_t kPictures = 2;
    using OfRays = std::array<Image, kPictures>;

    /// @param means  of what layersOfRays() gave
    explicit PictureLayers(OfRays&& means);

    /// RAM per pixel that paths' beginnings, layersOfRays(), sums and the layers take.
    /// @param most  samples of a pixel
    static std::size_t bytesPerPixel(int most);
};

/// @param beginnings  of rays
/// @param colours  of the same rays
PictureLayers::OfRays layersOfRays(std::span<const PathBeginning> beginnings, const Image& colours,
                                   const FramePlan& plan);

/// Depth of a place, mm: its distance from the eye; in parallel projection along the view from the camera's
/// position.
double depthMm(const Camera& camera, const VolumeInfo& info, const glm::dvec3& voxel);

} // namespace tessera
