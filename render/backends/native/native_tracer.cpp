// render/backends/native/native_tracer.cpp: see native_tracer.h.
#include "render/backends/native/native_tracer.h"

#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "render/backends/native/native_scene.h"

#include <algorithm>
#include <limits>

namespace tessera {

NativeTracer::NativeTracer(native::PacketScene scene, const native::PacketTarget& target, double voxels)
    : scene_(scene), lanes_(target.lanes()), voxels_(voxels) {
    scene_.optics.lit = false;
    scene_.optics.keepsOn = false;
    scene_.optics.termination = 0;
    scene_.optics.integrator = native::PacketIntegrator::midpoint;
    scene_.surfaces.showsDistances = true;
    if (!scene_.surfaces.volumeShows) {
        if (scene_.surfaces.space.map) // the volume's own does not matter
            scene_.space = scene_.surfaces.space;
        scene_.surfaces.space = scene_.space;
    }
    if (scene_.surfaces.count ==
        0) { // the march that tells distances is that of surfaces: of one that is nowhere
        scene_.surfaces.isovalue[0] = std::numeric_limits<float>::infinity();
        scene_.surfaces.count = 1;
    }
    scene_.field.segmentVoxels = static_cast<float>(voxels);
    scene_.help = {};
    scene_.help.expired = [](const void*) {
        checkInterrupted();
        return false;
    };
    march_ = target.march(scene_);
}

void NativeTracer::trace(std::span<const LightWay> ways, std::span<LightTaken> taken) const {
    TESSERA_CHECK(ways.size() == taken.size());
    native::PacketJob job;
    const auto lanes = static_cast<std::size_t>(lanes_);
    for (std::size_t first = 0; first < ways.size(); first += lanes) {
        const std::size_t count = std::min(lanes, ways.size() - first);
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            SegmentedRay<float> ray = segmentedWay<float>(ways[first + std::min(lane, count - 1)], voxels_);
            ray.count = lane < count ? ray.count : 0;
            setRay(job, static_cast<int>(lane), ray);
            job.next[lane] = 0;
            for (auto& column : job.colour)
                column[lane] = 0;
        }
        march_(scene_, job);
        for (std::size_t lane = 0; lane < count; ++lane)
            taken[first + lane] = {job.colour[3][lane], job.colour[0][lane]};
    }
}

} // namespace tessera
