// render/transport/path.h: one path of light, from the place that a ray of the eye sees to the lights
// (docs/sampling.md, "Paths"). One text for every field that has value(p), gradient(p) and labels(p): the
// mirror's and the native engine's.
#pragma once

#include "render/transport/surface_crossings.h"
#include "render/transport/traced_path.h"

#include <algorithm>
#include <array>
#include <glm/vec3.hpp>
#include <vector>

namespace tessera {

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
        PathTissue tissue{glm::vec3(entry), emissionOf(value), tissueNumber(scene_, value)};
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
        start(path, p, PathTissue{colour, emissionOf(value), tissueNumber(scene_, value)}, direction);
    }
    /// @param direction  voxels
    void start(TracedPath& path, const glm::vec3& p, const PathTissue& tissue,
               const glm::vec3& direction) const {
        path.p = p;
        path.tissue = tissue;
        const glm::vec3 d = inPatient(scene_.optics->patientFromVoxel, direction);
        path.travel = d / std::sqrt(glm::dot(d, d));
    }
    /// Its first light is what tissue there sends.
    void begin(TracedPath& path) const {
        path.sum = path.tissue.emission;
        ++work_.paths;
    }
    /// True if scatterings ask for gradients.
    bool takesGradients() const { return scene_.transport.surface.has_value() || !scene_.isovalues.empty(); }
    /// What an isosurface makes of light.
    PathTissue tissueOf(int isosurface) const {
        const SurfaceLook& surface = scene_.optics->surfaces[static_cast<std::size_t>(isosurface)];
        return {surface.colour, emissionOf(surface.isovalue)};
    }
    /// Scatters, and draws the way to one of the lights. False: no light comes from any.
    /// @param gradient  of the field at the path's place, where it is taken
    bool aim(TracedPath& path, const glm::vec3& gradient, Way& way) {
        ++path.bounce;
        ++work_.bounces;
        findScattering(scene_, path, gradient);
        if (scene_.lights.empty() && !scene_.skyTable)
            return false;
        const float u = path.numbers.next();
        const glm::vec2 two = path.numbers.pair(path.bounce == 1 ? 1 : kLater);
        // By the light that each would bring if nothing were in its way.
        constexpr std::size_t kMost = leaf::kMostLights + 1; // and the sky
        std::array<ToLight, kMost> ways;
        std::array<glm::vec3, kMost> shines;
        std::array<float, kMost> upTo; // sums
        std::size_t count = 0;
        float sum = 0;
        const auto take = [&](const ToLight& to, const glm::vec3& shine) {
            ways[count] = to;
            shines[count] = shine;
            upTo[count++] = sum += std::max({shine.r, shine.g, shine.b});
        };
        for (const PathLight& light : scene_.lights) {
            const ToLight to = wayTo(scene_, light, path.p, two);
            take(to, to.any ? lightOf(scene_, light, to, path) : glm::vec3(0.0f));
        }
        if (scene_.skyTable) {
            const ToSky to = wayToSky(scene_, two);
            take({true, to.towards}, lightOf(scene_, to, path));
        }
        if (!(sum > 0.0f))
            return false;
        std::size_t n = 0;
        while (n + 1 < count && !(u * sum < upTo[n]))
            ++n;
        const float weight = upTo[n] - (n > 0 ? upTo[n - 1] : 0.0f);
        if (!(weight > 0.0f))
            return false; // none of it, by rounding
        const ToLight& to = ways[n];
        path.shine = path.throughput * shines[n] * (sum / weight);
        way = wayOn(scene_, path, to.towards, to.mm);
        return true;
    }
    /// @param left  of the light that comes by that way
    static void shineBy(TracedPath& path, float left) { path.sum += path.shine * left; }
    /// Draws the way on. False: the path ends.
    bool turn(TracedPath& path, Way& way) {
        PathNumbers& numbers = path.numbers;
        const glm::vec2 two = numbers.pair(path.bounce == 1 ? 2 : kLater);
        glm::vec3 towards, share;
        if (path.isSurface) {
            if (!surfaceOf(scene_, path)
                     .sample(path.albedo, path.normal, -path.travel, numbers.next(), two.x, two.y, towards,
                             share))
                return false;
        } else {
            const float cosine =
                phaseCosine(responseOf(scene_, path).phase, two.x, [&] { return numbers.next(); });
            towards = directionAround(path.travel, cosine, two.y);
            share = path.albedo;
        }
        if (scene_.skyTable)
            path.density = densityOf(scene_, path, towards);
        path.travel = towards;
        path.throughput *= share;
        way = wayOn(scene_, path, path.travel, std::numeric_limits<float>::max());
        return true;
    }
    /// Takes the end of that way. False: the path left the volume.
    /// @param mm  of the first collision; below 0: there is none
    bool reach(TracedPath& path, const Way& way, float mm) const {
        if (mm < 0.0f) {
            path.sum += path.throughput * skyBeyond(scene_, path);
            return false;
        }
        path.p = way.from + mm * way.perMm;
        return true;
    }
    /// Takes the sky's light by a way that only takes some.
    /// @param left  of it
    void leave(TracedPath& path, float left) const {
        path.sum += path.throughput * skyBeyond(scene_, path) * left;
    }
    /// Takes what is at the path's place. False: the path ends.
    /// @param value  of the field there
    bool settle(TracedPath& path, float value) { return settle(path, tissueAt(path.p, value)); }
    bool settle(TracedPath& path, const PathTissue& tissue) const {
        path.tissue = tissue;
        path.sum += path.throughput * path.tissue.emission;
        if (path.bounce >= scene_.transport.bounces)
            return false;
        if (path.bounce >= kSureBounces) { // by roulette, which changes no mean
            const float most = std::max({path.throughput.r, path.throughput.g, path.throughput.b});
            const float stays = std::clamp(most, 0.05f, 1.0f);
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
            if (aim(path, takesGradients() ? field_.gradient(path.p, scene_.normals) : glm::vec3(0), way))
                shineBy(path, isSquared(scene_, path) ? path.passed : left(way, path.numbers));
            if (!turn(path, way))
                break;
            if (isLast(scene_, path)) {
                leave(path, isSquared(scene_, path) ? path.passed : left(way, path.numbers, false));
                break;
            }
            const float mm = toCollision(way, path);
            if (!reach(path, way, mm))
                break;
            if (asksWhatPassed(scene_, path))
                path.passed = left({way.from, way.perMm, mm}, path.numbers, false);
        } while (settle(path, path.isosurface >= 0 ? tissueOf(path.isosurface)
                                                   : tissueAt(path.p, field_.value(path.p))));
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
        const glm::vec3 gradient =
            labelled.isMedium() ? field_.mediumGradient(p) : field_.gradient(p, optics.normals);
        leaf::ReceivedLight<float> received{{1, 1, 1}, {1, 1, 1, 1}};
        for (const PathLight& light : scene_.lights)
            if (light.casts)
                received.from[light.number] = leftTowards(light, path);
        if (scene_.occlusion) {
            const float share = fromAllSides(path);
            for (float& all : received.fromAllSides)
                all = share;
        }
        return shade(optics, colour, gradient, direction, p, materialAt(optics, placeOf(optics, value)),
                     received);
    }

  private:
    static constexpr int kSureBounces = 4;
    static constexpr int kWaysOfPower = 16;
    static constexpr std::uint32_t kLater = 4; // of pairs: those that are drawn

    glm::vec3 emissionOf(float value) const {
        const Optics& optics = *scene_.optics;
        if (!optics.lighting.emits)
            return glm::vec3(0.0f);
        const leaf::Material<float> material = materialAt(optics, placeOf(optics, value));
        return {material.emission[0], material.emission[1], material.emission[2]};
    }

    /// @param surfaces  take light as well
    float left(const Way& way, PathNumbers& numbers, bool surfaces = true) {
        const auto of = [&](const Way& part) {
            float past = 1;
            if (surfaces && !scene_.isovalues.empty() &&
                crossSurfaces(scene_, field_, part, [&](float, std::size_t surface) {
                    past *= 1.0f - scene_.optics->surfaces[surface].opacity;
                    return !(past > 0.0f);
                }))
                return 0.0f;
            return past * transmittance(
                              *scene_.bounds, scene_.occupancy, part,
                              [&](const glm::vec3& q) { return extinctionAt(q); }, numbers, work_);
        };
        if (!scene_.cuts)
            return of(way);
        keptParts(*scene_.cuts, way, parts_);
        float left = 1;
        for (std::size_t n = 0; n < parts_.size() && left > 0.0f; ++n)
            left *= of(partOf(way, parts_[n]));
        return left;
    }
    /// mm; below 0: there is none. An isosurface before it is met with the chance of its opacity.
    float toCollision(const Way& way, TracedPath& path) {
        path.isosurface = -1;
        const auto of = [&](const Way& part) {
            float mm = freePath(
                *scene_.bounds, scene_.occupancy, part, [&](const glm::vec3& q) { return extinctionAt(q); },
                path.numbers, work_);
            if (scene_.isovalues.empty())
                return mm;
            Way before = part;
            if (mm >= 0.0f)
                before.mm = mm;
            crossSurfaces(scene_, field_, before, [&](float at, std::size_t surface) {
                const float opacity = scene_.optics->surfaces[surface].opacity;
                if (opacity < 1.0f && !(path.numbers.next() < opacity))
                    return false;
                mm = at;
                path.isosurface = static_cast<int>(surface);
                return true;
            });
            return mm;
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
        const ToLight to = wayTo(scene_, light, path.p, path.numbers.pair(1));
        if (!to.any)
            return 1.0f;
        Way way = wayFrom(scene_, path.p, to.towards);
        if (!light.isPoint || to.mm > scene_.leavesFromMm) {
            way = wayFrom(scene_, path.p + scene_.leavesFromMm * way.perMm, to.towards);
            way.mm = std::min(way.mm, to.mm - scene_.leavesFromMm);
        } else {
            way.mm = std::min(way.mm, to.mm);
        }
        return left(way, path.numbers);
    }
    /// Ambient light that local occlusion leaves. The mean of powers is not the power of the mean: where
    /// gamma is not 1, many ways are taken, and the bias that is left is taken from halves of them
    /// (jackknife).
    float fromAllSides(TracedPath& path) {
        const auto bias = static_cast<float>(scene_.occlusion->bias),
                   gamma = static_cast<float>(scene_.occlusion->gamma);
        if (gamma == 1.0f)
            return bias + leftAround(path, 2);
        float halves[2] = {0, 0};
        for (int n = 0; n < kWaysOfPower; ++n)
            halves[n % 2] += leftAround(path, n == 0 ? 2 : kLater) * (2.0f / kWaysOfPower);
        const auto power = [&](float left) { return std::pow(bias + left, gamma); };
        return 2.0f * power(0.5f * (halves[0] + halves[1])) - 0.5f * (power(halves[0]) + power(halves[1]));
    }
    /// Local occlusion's share, in the mean over directions and the ways' lengths.
    /// @param pair  of numbers
    float leftAround(TracedPath& path, std::uint32_t pair) {
        const glm::vec2 two = path.numbers.pair(pair);
        const glm::vec3 direction = directionAround({0, 0, 1}, 1.0f - 2.0f * two.x, two.y);
        const auto from = static_cast<float>(scene_.occlusion->offsetMm),
                   to = static_cast<float>(scene_.occlusion->radiusMm);
        Way way = wayFrom(scene_, path.p, direction);
        way = wayFrom(scene_, path.p + from * way.perMm, direction);
        way.mm = std::min(way.mm, path.numbers.pair(pair == kLater ? kLater : 3).x * (to - from));
        const float share = left(way, path.numbers);
        return scene_.occlusion->weights
                   ? share * static_cast<float>(directionWeight(*scene_.occlusion, glm::dvec3(direction)))
                   : share;
    }

    const PathScene& scene_;
    Field& field_;
    PathWork& work_;
    std::vector<RayPart> parts_; // of a way
};

} // namespace tessera
