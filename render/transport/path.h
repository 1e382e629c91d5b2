// render/transport/path.h: one path of light, from the place that a ray of the eye sees to the lights
// (docs/sampling.md, "Paths"). One text for every field that has value(p), gradient(p) and labels(p): the
// mirror's and the native engine's.
#pragma once

#include "render/contract/optics.h"
#include "render/transport/path_numbers.h"
#include "render/transport/path_scene.h"
#include "render/transport/phase.h"
#include "render/transport/tracking.h"

#include <algorithm>
#include <glm/vec3.hpp>

namespace tessera {

/// What a place makes of light.
struct PathTissue {
    float extinction = 0; // per mm
    glm::vec3 albedo{0}, emission{0};
};

template <typename Field> class PathTracer {
  public:
    PathTracer(const PathScene& scene, Field& field, PathNumbers& numbers, PathWork& work)
        : scene_(scene), field_(field), numbers_(numbers), work_(work) {}

    /// Extinction per mm.
    float extinctionAt(const glm::vec3& p) {
        const Optics& optics = *scene_.optics;
        float extinction = lookUp(optics, field_.value(p)).a;
        if (extinction > 0 && optics.grades())
            extinction *= gradientFactor(optics, field_.gradient(p));
        extinction = LabelledSample<float>(optics, field_, p).take(extinction);
        return std::min(extinction, scene_.bounds->limit());
    }

    PathTissue tissueAt(const glm::vec3& p) {
        const Optics& optics = *scene_.optics;
        const float value = field_.value(p);
        const glm::vec4 entry = lookUp(optics, value);
        PathTissue tissue;
        tissue.extinction = entry.a;
        if (entry.a > 0 && optics.grades())
            tissue.extinction *= gradientFactor(optics, field_.gradient(p));
        LabelledSample<float> labelled(optics, field_, p);
        tissue.extinction = labelled.take(tissue.extinction);
        tissue.albedo = labelled.colour(glm::vec3(entry));
        if (optics.lighting.emits) {
            const leaf::Material<float> material = materialAt(optics, clampedPlaceOf(optics, value));
            tissue.emission = {material.emission[0], material.emission[1], material.emission[2]};
        }
        return tissue;
    }

    /// Light that a place sends to where the path comes from, after any number of scatterings.
    /// @param p  voxels
    /// @param travel  of the path, unit, patient space
    glm::vec3 lightFrom(glm::vec3 p, PathTissue tissue, glm::vec3 travel) {
        glm::vec3 sum = tissue.emission, throughput = tissue.albedo;
        ++work_.paths;
        for (int bounce = 1; bounce <= scene_.transport.bounces; ++bounce) {
            ++work_.bounces;
            sum += throughput * lightOfLights(p, travel);
            const float cosine = phaseCosine(scene_.transport.phase, [&] { return numbers_.next(); });
            travel = directionAround(travel, cosine, numbers_.next());
            const Flight flight = flightFrom(p, travel);
            const float mm = freePath(
                *scene_.bounds, scene_.occupancy, flight, [&](const glm::vec3& q) { return extinctionAt(q); },
                numbers_, work_);
            if (mm < 0.0f) {
                sum += throughput * skyFrom(scene_, travel);
                break;
            }
            p = flight.from + mm * flight.perMm;
            tissue = tissueAt(p);
            sum += throughput * tissue.emission;
            throughput *= tissue.albedo;
            if (bounce >= kSureBounces) { // by roulette, which changes no mean
                const float most = std::max({throughput.r, throughput.g, throughput.b});
                const float stays = std::clamp(most, 0.05f, 0.95f);
                if (!(numbers_.next() < stays))
                    break;
                throughput /= stays;
            }
        }
        return sum;
    }

  private:
    static constexpr int kSureBounces = 4;

    Flight flightFrom(const glm::vec3& p, const glm::vec3& direction) const {
        const glm::vec3 perMm = scene_.voxelFromPatient * direction;
        return {p, perMm, mmToLeave(p, perMm, scene_.extent)};
    }

    /// Light of one of the lights, drawn by its power, scattered into the path.
    glm::vec3 lightOfLights(const glm::vec3& p, const glm::vec3& travel) {
        if (scene_.lights.empty())
            return glm::vec3(0.0f);
        float u = numbers_.next();
        std::size_t n = 0;
        while (n + 1 < scene_.lights.size() && !(u < scene_.lights[n].chance))
            u -= scene_.lights[n++].chance;
        const PathLight& light = scene_.lights[n];
        glm::vec3 power = light.power, towards = light.towards;
        float mm = std::numeric_limits<float>::max();
        if (light.isPoint) {
            const glm::vec3 way = scene_.optics->patientFromVoxel * (light.towards - p);
            mm = std::sqrt(way.x * way.x + way.y * way.y + way.z * way.z);
            if (!(mm > 0.0f))
                return glm::vec3(0.0f);
            towards = way / mm;
            power /= light.fading.x + mm * (light.fading.y + mm * light.fading.z);
        }
        if (light.cosine < 1.0f) {
            const float cosine = 1.0f - numbers_.next() * (1.0f - light.cosine);
            towards = directionAround(towards, cosine, numbers_.next());
        }
        Flight flight = flightFrom(p, towards);
        flight.mm = std::min(flight.mm, mm);
        const float phase = phaseOf(scene_.transport.phase,
                                    travel.x * towards.x + travel.y * towards.y + travel.z * towards.z);
        const float left = transmittance(
            *scene_.bounds, scene_.occupancy, flight, [&](const glm::vec3& q) { return extinctionAt(q); },
            numbers_, work_);
        return power * (phase * left / light.chance);
    }

    const PathScene& scene_;
    Field& field_;
    PathNumbers& numbers_;
    PathWork& work_;
};

} // namespace tessera
