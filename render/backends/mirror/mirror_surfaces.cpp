// render/backends/mirror/mirror_surfaces.cpp: see mirror_surfaces.h.
#include "render/backends/mirror/mirror_surfaces.h"

#include "core/base/error.h"
#include "render/contract/lattice.h"

namespace tessera {
namespace {

/// A field without light.
template <typename Values> struct UnlitField {
    Values& values;
    float value(const glm::vec3& p) { return values.value(p); }
    float pitch(const glm::vec3& p) { return values.pitch(p); }
    glm::vec3 gradient(const glm::vec3& p) { return values.gradient(p); }
    glm::vec3 gradient(const glm::vec3& p, Gradient by) { return values.gradient(p, by); }
    leaf::ReceivedLight<float> received(const glm::vec3&, const leaf::LightingNumbers&) {
        TESSERA_CHECK(false);
        return {};
    }
};

} // namespace

MirrorTracer::MirrorTracer(const FramePlan& scene, double voxels)
    : input_(mirrorInput(scene, scene.view.quality.skipping)) {
    const Optics& drawn = scene.layer().optics;
    if (drawn.volumeShows) {
        optics_ = drawn;
        setIntegrator(optics_, Integrator::midpoint);
        optics_.shading = optics_.hasLights = false;
        optics_.lighting = {};
        optics_.termination = 0;
    } else {
        optics_.surfaces = drawn.surfaces;
        optics_.volumeShows = false;
        if (input_.surfaceOccupancy) // the volume's own is irrelevant
            input_.occupancy = input_.surfaceOccupancy;
        input_.surfaceOccupancy = nullptr;
    }
    input_.optics = &optics_;
    input_.strides.segmentVoxels = voxels;
    input_.showsDistances = true;
}

void MirrorTracer::trace(std::span<const LightWay> ways, std::span<LightTaken> taken) const {
    TESSERA_CHECK(ways.size() == taken.size());
    Work unused;
    withCacheField<float>(*input_.cache, *input_.info, *input_.selection, input_.levels, optics_.gradient,
                          [&](auto& values) {
                              UnlitField<std::decay_t<decltype(values)>> field{values};
                              for (std::size_t n = 0; n < ways.size(); ++n) {
                                  SurfaceRayState<float> state;
                                  surfaceRay(segmentedWay<float>(ways[n], input_.strides.segmentVoxels),
                                             field, input_, unused, nullptr, state);
                                  taken[n] = {state.sum.a, state.sum.r};
                              }
                          });
}

} // namespace tessera
