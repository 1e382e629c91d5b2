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
        glm::vec3 sum = tissue.emission, throughput(1.0f);
        ++work_.paths;
        for (int bounce = 1; bounce <= scene_.transport.bounces; ++bounce) {
            ++work_.bounces;
            const Normal normal = normalAt(p, travel);
            sum += throughput * lightOfLights(p, tissue.albedo, normal, travel, bounce == 1);
            if (!turn(tissue.albedo, normal, bounce == 1, travel, throughput))
                break;
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
    static constexpr std::uint32_t kLater = 4; // of pairs: those that are drawn

    /// Unit, patient space, on the viewer's side; none: the place scatters as a medium.
    struct Normal {
        bool any = false;
        glm::vec3 n{0};
    };
    /// Steep places are surfaces, others with the chance that the length of their gradient gives them.
    Normal normalAt(const glm::vec3& p, const glm::vec3& travel) {
        Normal normal;
        if (!scene_.transport.surface)
            return normal;
        const glm::vec3 g = leaf::transformed(scene_.optics->voxelFromPatientTransposed, field_.gradient(p));
        const float length = std::sqrt(g.x * g.x + g.y * g.y + g.z * g.z);
        const float t = std::clamp((length - scene_.steepFrom) * scene_.perSteep, 0.0f, 1.0f);
        const float chance = t * t * (3.0f - 2.0f * t);
        normal.any = numbers_.next() < chance && length > 0.0f;
        if (normal.any) {
            normal.n = g / length;
            if (normal.n.x * travel.x + normal.n.y * travel.y + normal.n.z * travel.z > 0.0f)
                normal.n = -normal.n;
        }
        return normal;
    }

    /// Draws the way on. False: no light comes from there.
    bool turn(const glm::vec3& albedo, const Normal& normal, bool first, glm::vec3& travel,
              glm::vec3& throughput) {
        const glm::vec2 two = numbers_.pair(first ? 2 : kLater);
        if (normal.any) {
            glm::vec3 towards, share;
            if (!scene_.surface.sample(albedo, normal.n, -travel, numbers_.next(), two.x, two.y, towards,
                                       share))
                return false;
            travel = towards;
            throughput *= share;
            return true;
        }
        const float cosine = phaseCosine(scene_.transport.phase, two.x, [&] { return numbers_.next(); });
        travel = directionAround(travel, cosine, two.y);
        throughput *= albedo;
        return true;
    }

    Flight flightFrom(const glm::vec3& p, const glm::vec3& direction) const {
        const glm::vec3 perMm = scene_.voxelFromPatient * direction;
        return {p, perMm, mmToLeave(p, perMm, scene_.extent)};
    }

    /// Light of one of the lights, drawn by its power, scattered into the path.
    glm::vec3 lightOfLights(const glm::vec3& p, const glm::vec3& albedo, const Normal& normal,
                            const glm::vec3& travel, bool first) {
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
            const glm::vec2 two = numbers_.pair(first ? 1 : kLater);
            towards = directionAround(towards, 1.0f - two.x * (1.0f - light.cosine), two.y);
        }
        Flight flight = flightFrom(p, towards);
        flight.mm = std::min(flight.mm, mm);
        glm::vec3 scattered;
        if (normal.any) {
            const float slant = normal.n.x * towards.x + normal.n.y * towards.y + normal.n.z * towards.z;
            if (!(slant > 0.0f))
                return glm::vec3(0.0f);
            scattered = scene_.surface.of(albedo, normal.n, -travel, towards) * slant;
        } else {
            const float cosine = travel.x * towards.x + travel.y * towards.y + travel.z * towards.z;
            scattered = albedo * phaseOf(scene_.transport.phase, cosine);
        }
        const float left = transmittance(
            *scene_.bounds, scene_.occupancy, flight, [&](const glm::vec3& q) { return extinctionAt(q); },
            numbers_, work_);
        return power * scattered * (left / light.chance);
    }

    const PathScene& scene_;
    Field& field_;
    PathNumbers& numbers_;
    PathWork& work_;
};

} // namespace tessera
