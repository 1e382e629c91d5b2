// render/pixels/picture_layers.cpp: see picture_layers.h.
#include "render/pixels/picture_layers.h"

#include "core/base/error.h"
#include "render/pixels/pixel_sums.h"

#include <glm/geometric.hpp>
#include <utility>

namespace tessera {

double depthMm(const Camera& camera, const VolumeInfo& info, const glm::dvec3& voxel) {
    const glm::dvec3 way = glm::dvec3(info.patientFromVoxel * glm::dvec4(voxel, 1)) - camera.position;
    return camera.projection == Projection::perspective
               ? glm::length(way)
               : glm::dot(way, glm::normalize(camera.focalPoint - camera.position));
}

PictureLayers::OfRays layersOfRays(std::span<const PathBeginning> beginnings, const Image& colours,
                                   const FramePlan& plan) {
    TESSERA_CHECK(beginnings.size() == colours.pixels.size());
    PictureLayers::OfRays layers = {Image(colours.size), Image(colours.size)};
    for (std::size_t i = 0; i < beginnings.size(); ++i) {
        const PathBeginning& at = beginnings[i];
        const float alpha = colours.pixels[i].a * at.any;
        if (!(alpha > 0))
            continue;
        const auto depth = static_cast<float>(depthMm(plan.view.camera, plan.info(), glm::dvec3(at.place)));
        layers[0].pixels[i] = {alpha * at.albedo, alpha};
        layers[1].pixels[i] = {alpha * at.normal, alpha * depth};
    }
    return layers;
}

PictureLayers::PictureLayers(OfRays&& means) : albedo(std::move(means[0])), normal(std::move(means[1])) {
    for (std::size_t i = 0; i < albedo.pixels.size(); ++i)
        if (albedo.pixels[i].a > 0)
            normal.pixels[i].a /= albedo.pixels[i].a;
}

std::size_t PictureLayers::bytesPerPixel(int most) {
    const std::size_t ofRays = sizeof(PathBeginning) + kPictures * sizeof(glm::vec4);
    const std::size_t sums = most == 1 ? 0 : kPictures * PixelSums::bytesPerPixel(most);
    return ofRays + sums + kPictures * sizeof(glm::vec4);
}

} // namespace tessera
