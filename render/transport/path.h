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
#include <array>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

namespace tessera {

/// What a place makes of light.
struct PathTissue {
    glm::vec3 albedo{0}, emission{0};
};

/// A path between its scatterings.
struct TracedPath {
    /// @param place  of its ray on the picture, pixels
    /// @param number  of its sample (Rays::numbers), where its pixel has several
    TracedPath(const PathScene& scene, const glm::vec2& place, std::optional<std::uint32_t> number = {})
        : numbers(place, scene.seed) {
        if (number)
            numbers.setSample(*number);
    }

    PathNumbers numbers;
    glm::vec3 p{0};                  // voxels
    glm::vec3 travel{0};             // unit, patient space
    PathTissue tissue;               // there
    glm::vec3 sum{0}, throughput{1}; // of light
    int bounce = 0;                  // scatterings
    /// Of a surface, unit, patient space, on the viewer's side; none: the place scatters as a medium.
    bool isSurface = false;
    glm::vec3 normal{0};
    glm::vec3 shine{0}; // the light that comes by aim()'s way, where nothing is in it
};

/// Takes paths from scattering to scattering. Ways between places are for who calls: one by one
/// (lightFrom()), or many side by side.
template <typename Field> class PathTracer {
  public:
    PathTracer(const PathScene& scene, Field& field, PathWork& work)
        : scene_(scene), field_(field), work_(work) {}

    /// Extinction per mm.
    float extinctionAt(const glm::vec3& p) {
        const Optics& optics = *scene_.optics;
        float extinction = lookUp(optics, field_.value(p)).a;
        if (extinction > 0 && optics.grades())
            extinction *= gradientFactor(optics, field_.gradient(p));
        extinction = LabelledSample<float>(optics, field_, p).take(extinction);
        return std::min(extinction, scene_.bounds->limit());
    }

    /// What a place's tissue makes of light.
    /// @param value  of the field there, as stored
    PathTissue tissueAt(const glm::vec3& p, float value) {
        const Optics& optics = *scene_.optics;
        const glm::vec4 entry = lookUp(optics, value);
        PathTissue tissue{glm::vec3(entry), emissionOf(value)};
        if (optics.labels.count > 0 && optics.labels.colour >= 0) {
            float extinction = entry.a;
            if (extinction > 0 && optics.grades())
                extinction *= gradientFactor(optics, field_.gradient(p));
            LabelledSample<float> labelled(optics, field_, p);
            labelled.take(extinction);
            tissue.albedo = labelled.colour(tissue.albedo);
        }
        return tissue;
    }

    /// Puts a path where a ray sees something.
    /// @param colour  that it sees
    /// @param direction  of the ray, unit, voxels
    /// @param value  of the field there
    void start(TracedPath& path, const glm::vec3& p, const glm::vec3& colour, const glm::vec3& direction,
               float value) {
        path.p = p;
        path.tissue = {colour, emissionOf(value)};
        const glm::vec3 d = inPatient(scene_.optics->patientFromVoxel, direction);
        path.travel = d / std::sqrt(dot(d, d));
    }
    /// Its first light is what tissue there sends.
    void begin(TracedPath& path) const {
        path.sum = path.tissue.emission;
        ++work_.paths;
    }
    /// True if scatterings ask for gradients.
    bool takesGradients() const { return scene_.transport.surface.has_value(); }
    /// Scatters, and draws the way to one of the lights. False: no light comes from any.
    /// @param gradient  of the field at the path's place, where it is taken
    bool aim(TracedPath& path, const glm::vec3& gradient, Way& way) {
        ++path.bounce;
        ++work_.bounces;
        findNormal(path, gradient);
        if (scene_.lights.empty())
            return false;
        const float u = path.numbers.next();
        const glm::vec2 two = path.numbers.pair(path.bounce == 1 ? 1 : kLater);
        // By the light that each would bring if nothing were in its way.
        std::array<ToLight, leaf::kMostLights> ways;
        std::array<glm::vec3, leaf::kMostLights> shines;
        std::array<float, leaf::kMostLights> upTo; // sums
        float sum = 0;
        for (std::size_t n = 0; n < scene_.lights.size(); ++n) {
            const PathLight& light = scene_.lights[n];
            ways[n] = wayTo(light, path.p, two);
            shines[n] = ways[n].any ? lightOf(light, ways[n], path) : glm::vec3(0.0f);
            upTo[n] = sum += std::max({shines[n].r, shines[n].g, shines[n].b});
        }
        if (!(sum > 0.0f))
            return false;
        std::size_t n = 0;
        while (n + 1 < scene_.lights.size() && !(u * sum < upTo[n]))
            ++n;
        const float weight = upTo[n] - (n > 0 ? upTo[n - 1] : 0.0f);
        if (!(weight > 0.0f))
            return false; // none of it, by rounding
        const ToLight& to = ways[n];
        path.shine = path.throughput * shines[n] * (sum / weight);
        way = wayOn(path, to.towards, to.mm);
        return true;
    }
    /// @param left  of the light that comes by that way
    static void shineBy(TracedPath& path, float left) { path.sum += path.shine * left; }
    /// Draws the way on. False: the path ends.
    bool turn(TracedPath& path, Way& way) {
        PathNumbers& numbers = path.numbers;
        const glm::vec2 two = numbers.pair(path.bounce == 1 ? 2 : kLater);
        if (path.isSurface) {
            glm::vec3 towards, share;
            if (!scene_.surface.sample(path.tissue.albedo, path.normal, -path.travel, numbers.next(), two.x,
                                       two.y, towards, share))
                return false;
            path.travel = towards;
            path.throughput *= share;
        } else {
            const float cosine = phaseCosine(scene_.transport.phase, two.x, [&] { return numbers.next(); });
            path.travel = directionAround(path.travel, cosine, two.y);
            path.throughput *= path.tissue.albedo;
        }
        way = wayOn(path, path.travel, std::numeric_limits<float>::max());
        return true;
    }
    /// Takes the end of that way. False: the path left the volume.
    /// @param mm  of the first collision; below 0: there is none
    bool reach(TracedPath& path, const Way& way, float mm) const {
        if (mm < 0.0f) {
            path.sum += path.throughput * skyFrom(scene_, path.travel);
            return false;
        }
        path.p = way.from + mm * way.perMm;
        return true;
    }
    /// Takes what is at the path's place. False: the path ends.
    /// @param value  of the field there
    bool settle(TracedPath& path, float value) {
        path.tissue = tissueAt(path.p, value);
        path.sum += path.throughput * path.tissue.emission;
        if (path.bounce >= scene_.transport.bounces)
            return false;
        if (path.bounce >= kSureBounces) { // by roulette, which changes no mean
            const float most = std::max({path.throughput.r, path.throughput.g, path.throughput.b});
            const float stays = std::clamp(most, 0.05f, 0.95f);
            if (!(path.numbers.next() < stays))
                return false;
            path.throughput /= stays;
        }
        return true;
    }

    /// Light that a path's place sends to where it comes from, after any number of scatterings.
    glm::vec3 lightFrom(TracedPath& path) {
        begin(path);
        Way way;
        do {
            if (aim(path, takesGradients() ? field_.gradient(path.p) : glm::vec3(0), way))
                shineBy(path, left(way, path.numbers));
            if (!turn(path, way))
                break;
        } while (reach(path, way, toCollision(way, path.numbers)) && settle(path, field_.value(path.p)));
        return path.sum;
    }

    /// The colour that docs/sampling.md gives a path's place under "Shading", its shares of light each by one
    /// way.
    /// @param colour  of the function
    /// @param direction  of the ray, unit, voxels
    glm::vec3 contractColour(TracedPath& path, const glm::vec3& colour, const glm::vec3& direction) {
        const Optics& optics = *scene_.optics;
        const glm::vec3& p = path.p;
        ++work_.paths;
        const float value = field_.value(p);
        LabelledSample<float> labelled(optics, field_, p);
        labelled.take(lookUp(optics, value).a);
        const glm::vec3 gradient = labelled.isMedium() ? field_.mediumGradient(p) : field_.gradient(p);
        leaf::ReceivedLight<float> received{{1, 1, 1}, {1, 1, 1, 1}};
        for (const PathLight& light : scene_.lights)
            if (light.casts)
                received.from[light.number] = leftTowards(light, path);
        if (scene_.occlusion) {
            const float share = static_cast<float>(scene_.occlusion->bias) + leftAround(path);
            for (float& all : received.fromAllSides)
                all = share;
        }
        return shade(optics, colour, gradient, direction, p, materialAt(optics, placeOf(optics, value)),
                     received);
    }

  private:
    static constexpr int kSureBounces = 4;
    static constexpr std::uint32_t kLater = 4; // of pairs: those that are drawn

    static float dot(const glm::vec3& a, const glm::vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

    glm::vec3 emissionOf(float value) const {
        const Optics& optics = *scene_.optics;
        if (!optics.lighting.emits)
            return glm::vec3(0.0f);
        const leaf::Material<float> material = materialAt(optics, placeOf(optics, value));
        return {material.emission[0], material.emission[1], material.emission[2]};
    }

    /// Steep places are surfaces, others with the chance that the length of their gradient gives them.
    void findNormal(TracedPath& path, const glm::vec3& gradient) const {
        path.isSurface = false;
        if (!takesGradients())
            return;
        const glm::vec3 g = leaf::transformed(scene_.optics->voxelFromPatientTransposed, gradient);
        const float length = std::sqrt(dot(g, g));
        const float t = std::clamp((length - scene_.steepFrom) * scene_.perSteep, 0.0f, 1.0f);
        path.isSurface = path.numbers.next() < t * t * (3.0f - 2.0f * t) && length > 0.0f;
        if (path.isSurface) {
            path.normal = g / length;
            if (dot(path.normal, path.travel) > 0.0f)
                path.normal = -path.normal;
        }
    }

    Way wayFrom(const glm::vec3& p, const glm::vec3& direction) const {
        const glm::vec3 perMm = scene_.voxelFromPatient * direction;
        Way way{p, perMm, mmToLeave(p, perMm, scene_.extent)};
        for (const RaySlab<float>& slab : scene_.slabs)
            way.mm = std::min(way.mm, mmToLeave(p, perMm, slab));
        return way;
    }

    /// The way that light takes from a scattering, of a length at most. A surface stands for all that its
    /// tissue becomes within some voxels: ways begin beyond it.
    Way wayOn(const TracedPath& path, const glm::vec3& direction, float most) const {
        Way way = wayFrom(path.p, direction);
        if (path.isSurface && way.mm > scene_.leavesFromMm && most > scene_.leavesFromMm) {
            way = wayFrom(path.p + scene_.leavesFromMm * way.perMm, direction);
            most -= scene_.leavesFromMm;
        }
        way.mm = std::min(way.mm, most);
        return way;
    }

    /// The way from a path's place to a light: the direction, drawn within the light's own, and where it
    /// ends.
    struct ToLight {
        bool any = false;
        glm::vec3 towards{0}; // unit, patient space
        float mm = std::numeric_limits<float>::max();
    };
    /// @param two  random numbers
    ToLight wayTo(const PathLight& light, const glm::vec3& p, const glm::vec2& two) const {
        ToLight to{true, light.towards};
        if (light.isPoint) {
            const glm::vec3 way = scene_.optics->patientFromVoxel * (light.towards - p);
            to.mm = std::sqrt(dot(way, way));
            to.any = to.mm > 0.0f;
            to.towards = to.any ? way / to.mm : way;
        }
        if (to.any && light.cosine < 1.0f)
            to.towards = directionAround(to.towards, 1.0f - two.x * (1.0f - light.cosine), two.y);
        return to;
    }
    /// What a path's place makes of the light that comes by such a way, if nothing is in it.
    glm::vec3 lightOf(const PathLight& light, const ToLight& to, const TracedPath& path) const {
        glm::vec3 scattered;
        if (path.isSurface) {
            const float slant = dot(path.normal, to.towards);
            if (!(slant > 0.0f))
                return glm::vec3(0.0f);
            scattered = scene_.surface.of(path.tissue.albedo, path.normal, -path.travel, to.towards) * slant;
        } else {
            scattered = path.tissue.albedo * phaseOf(scene_.transport.phase, dot(path.travel, to.towards));
        }
        glm::vec3 power = light.power;
        if (light.isPoint)
            power /= light.fading.x + to.mm * (light.fading.y + to.mm * light.fading.z);
        return power * scattered;
    }
    float left(const Way& way, PathNumbers& numbers) {
        const auto of = [&](const Way& part) {
            return transmittance(
                *scene_.bounds, scene_.occupancy, part, [&](const glm::vec3& q) { return extinctionAt(q); },
                numbers, work_);
        };
        if (!scene_.cuts)
            return of(way);
        keptParts(*scene_.cuts, way, parts_);
        float left = 1;
        for (std::size_t n = 0; n < parts_.size() && left > 0.0f; ++n)
            left *= of(partOf(way, parts_[n]));
        return left;
    }
    /// mm; below 0: there is none.
    float toCollision(const Way& way, PathNumbers& numbers) {
        const auto of = [&](const Way& part) {
            return freePath(
                *scene_.bounds, scene_.occupancy, part, [&](const glm::vec3& q) { return extinctionAt(q); },
                numbers, work_);
        };
        if (!scene_.cuts)
            return of(way);
        keptParts(*scene_.cuts, way, parts_);
        for (const RayPart& part : parts_)
            if (const float mm = of(partOf(way, part)); mm >= 0.0f)
                return static_cast<float>(part.from) + mm;
        return -1;
    }

    /// Light that a shadow leaves.
    float leftTowards(const PathLight& light, TracedPath& path) {
        const ToLight to = wayTo(light, path.p, path.numbers.pair(1));
        if (!to.any)
            return 1.0f;
        Way way = wayFrom(path.p, to.towards);
        if (!light.isPoint || to.mm > scene_.leavesFromMm) {
            way = wayFrom(path.p + scene_.leavesFromMm * way.perMm, to.towards);
            way.mm = std::min(way.mm, to.mm - scene_.leavesFromMm);
        } else {
            way.mm = std::min(way.mm, to.mm);
        }
        return left(way, path.numbers);
    }
    /// Local occlusion's share, in the mean over directions and the ways' lengths.
    float leftAround(TracedPath& path) {
        const glm::vec2 two = path.numbers.pair(2);
        const glm::vec3 direction = directionAround({0, 0, 1}, 1.0f - 2.0f * two.x, two.y);
        const auto from = static_cast<float>(scene_.occlusion->offsetMm),
                   to = static_cast<float>(scene_.occlusion->radiusMm);
        Way way = wayFrom(path.p, direction);
        way = wayFrom(path.p + from * way.perMm, direction);
        way.mm = std::min(way.mm, path.numbers.pair(3).x * (to - from));
        return left(way, path.numbers);
    }

    const PathScene& scene_;
    Field& field_;
    PathWork& work_;
    std::vector<RayPart> parts_; // of a way
};

} // namespace tessera
