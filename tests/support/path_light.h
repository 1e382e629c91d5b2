// Light that comes out of a small volume along paths, in the mean, with its standard error; lights and
// transports for it.
#pragma once

#include "render/transport/path.h"
#include "tests/support/path_volume.h"

#include <cmath>
#include <gtest/gtest.h>

namespace tessera {

struct Mean {
    double mean = 0, error = 0; // and its standard error
};

/// Light that comes out of a volume against a way, in the mean over many paths, red.
template <typename Volume>
Mean lightAgainst(const Volume& volume, const PathScene& scene, const glm::vec3& from,
                  const glm::vec3& travel, int paths) {
    double sum = 0, squares = 0;
    PathWork work;
    for (int number = 0; number < paths; ++number) {
        TracedPath path(scene,
                        {static_cast<float>(number % 4096) + 0.5f, static_cast<float>(number / 4096) + 0.5f});
        PathTracer tracer(scene, volume, work);
        const glm::vec3 perMm = scene.voxelFromPatient * travel;
        const Way way{from, perMm, mmToLeave(from, perMm, scene.extent)};
        const float mm = freePath(
            *scene.bounds, scene.occupancy, way, [&](const glm::vec3& p) { return tracer.extinctionAt(p); },
            path.numbers, work);
        double light = 0;
        if (mm >= 0) {
            path.p = from + mm * perMm;
            path.travel = travel;
            path.tissue = tracer.tissueAt(path.p, volume.value(path.p));
            light = static_cast<double>(tracer.lightFrom(path).r);
        } else {
            light = static_cast<double>(skyFrom(scene, travel).r);
        }
        sum += light, squares += light * light;
    }
    const double mean = sum / paths;
    EXPECT_EQ(work.exceeded, 0u);
    return {mean, std::sqrt(std::max(squares / paths - mean * mean, 0.0) / paths)};
}

inline Light lightFrom(const glm::dvec3& towards, double intensity = 1) {
    Light light;
    light.kind = LightKind::directional;
    light.frame = LightFrame::patient;
    light.direction = towards;
    light.intensity = intensity;
    return light;
}

inline Transport transportOf(int bounces, const Phase& phase = {}) {
    Transport transport;
    transport.bounces = bounces;
    transport.phase = phase;
    return transport;
}

} // namespace tessera
