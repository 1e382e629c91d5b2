// tests/bench/peer_truth.cpp: see peer_truth.h.
#include "tests/bench/peer_truth.h"

#include "render/backends/reference/reference.h"
#include "render/contract/ray.h"

#include <algorithm>
#include <glm/matrix.hpp>

namespace tessera::bench {
namespace {

/// See borderPixels().
bool grazesBorder(const ReferenceRay& ray, const VolumeInfo& info) {
    const glm::dvec3 extent(info.extentVoxels), along = glm::abs(ray.direction);
    double t0 = 0, t1 = 0;
    if (!clipToBox(RayLine<double>{ray.base, ray.direction, ray.tMin, 1}, extent, t0, t1))
        return true;
    for (int axis = 0; axis < 3; ++axis) {
        if (along[axis] == std::max({along.x, along.y, along.z}))
            continue;
        const double a = ray.base[axis] + t0 * ray.direction[axis];
        const double b = ray.base[axis] + t1 * ray.direction[axis];
        if (std::min(a, b) < 0.5 || std::max(a, b) > extent[axis] - 0.5)
            return true;
    }
    return false;
}

} // namespace

Image roundedTo8Bits(Image image) {
    for (glm::vec4& pixel : image.pixels)
        pixel = glm::round(glm::clamp(pixel, 0.0f, 1.0f) * 255.0f) / 255.0f;
    return image;
}

Image referenceImage(BrickCache& cache, const FramePlan& p, const Shading& shading, const glm::ivec2& size,
                     int stride, const glm::dvec2& shift) {
    const VolumeInfo& info = p.info();
    const std::vector<ReferenceRay> rays = referenceRays(p.view.camera, info, size, stride, shift);
    const ReferenceInput input{&cache, &info, &p.layer().function, shading, &p.layer().statistics};
    const std::vector<glm::dvec4> values = renderReference(input, rays, 0);
    Image out(thinnedSize(size, stride));
    std::transform(values.begin(), values.end(), out.pixels.begin(),
                   [](const glm::dvec4& v) { return glm::vec4(v); });
    return out;
}

std::vector<bool> borderPixels(const FramePlan& p, const glm::ivec2& size, int stride) {
    std::vector<bool> border;
    for (const ReferenceRay& ray : referenceRays(p.view.camera, p.info(), size, stride))
        border.push_back(grazesBorder(ray, p.info()));
    return border;
}

Image without(Image image, const std::vector<bool>& leftOut) {
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
        if (leftOut[i])
            image.pixels[i] = glm::vec4(0);
    return image;
}

} // namespace tessera::bench
