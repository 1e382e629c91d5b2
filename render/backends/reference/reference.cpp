// render/backends/reference/reference.cpp: see reference.h.
#include "render/backends/reference/reference.h"

#include "core/base/threads.h"
#include "core/image/image.h"
#include "render/backends/reference/fused_integral.h"
#include "render/backends/reference/ray_integral.h"
#include "render/backends/reference/reference_paths.h"

#include <algorithm>
#include <limits>
#include <optional>

namespace tessera {
namespace {

/// A camera's rays by points on the picture, in pixels.
class RayMaker {
  public:
    RayMaker(const Camera& camera, const VolumeInfo& info, const glm::ivec2& size)
        : plane_(rayPlane(camera, info, size)), size_(size),
          voxelFromPatient_(glm::inverse(info.patientFromVoxel)) {}
    ReferenceRay operator()(const glm::dvec2& place) const {
        const PatientRay ray = pixelRay(plane_, place, size_);
        return {glm::dvec3(voxelFromPatient_ * glm::dvec4(ray.base, 1)),
                glm::dmat3(voxelFromPatient_) * ray.direction,
                std::max(ray.minT, -std::numeric_limits<double>::max())};
    }

  private:
    RayPlane plane_;
    glm::ivec2 size_;
    glm::dmat4 voxelFromPatient_;
};

} // namespace

std::vector<ReferenceRay> referenceRays(const Camera& camera, const VolumeInfo& info, const glm::ivec2& size,
                                        int stride, const glm::dvec2& shift) {
    const RayMaker ray(camera, info, size);
    std::vector<ReferenceRay> rays;
    const glm::ivec2 kept = thinnedSize(size, stride);
    rays.reserve(static_cast<std::size_t>(kept.x) * static_cast<std::size_t>(kept.y));
    for (int y = 0; y < kept.y; ++y)
        for (int x = 0; x < kept.x; ++x) {
            const glm::dvec2 pixel(thinnedPixel({x, y}, size, stride));
            rays.push_back(ray(pixel + 0.5 + shift));
        }
    return rays;
}

std::vector<ReferenceRay> referenceRays(const Camera& camera, const VolumeInfo& info, const glm::ivec2& size,
                                        std::span<const glm::vec2> places) {
    const RayMaker ray(camera, info, size);
    std::vector<ReferenceRay> rays;
    rays.reserve(places.size());
    for (const glm::vec2& place : places)
        rays.push_back(ray(glm::dvec2(place)));
    return rays;
}

Optics shadingOf(const ReferenceInput& input) {
    TransferTable table;
    table.gradientOpacity = input.function->gradientOpacity();
    Optics optics = makeOptics(table, *input.info, input.shading, 0);
    setLighting(optics, input.shading, input.lighting, input.function->materials(), input.camera,
                *input.info);
    if (input.labels)
        optics.labels = input.labels->labels().numbers();
    return optics;
}

std::vector<glm::dvec4> renderReference(const ReferenceInput& input, const std::vector<ReferenceRay>& rays,
                                        int threads) {
    if (input.fused)
        return renderFused(input, rays, threads);
    const IntegralInput of(input);
    constexpr std::size_t kStrip = 16;
    std::vector<glm::dvec4> out(rays.size());
    parallelFor((rays.size() + kStrip - 1) / kStrip, threads,
                [&](std::size_t strip) {
                    LatticeReader samples(*input.cache, *input.info, 0, nullptr);
                    RayIntegral integral(of, samples);
                    std::optional<ReferencePaths> paths;
                    if (input.paths)
                        paths.emplace(of, samples);
                    for (std::size_t i = strip * kStrip; i < std::min(rays.size(), (strip + 1) * kStrip);
                         ++i) {
                        out[i] = integral(rays[i]);
                        if (paths && out[i].a > 0)
                            out[i] = (*paths)(rays[i], integral.parts(), out[i].a, input.starts[i]);
                    }
                },
                input.progress);
    return out;
}

} // namespace tessera
