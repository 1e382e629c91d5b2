// render/light/reflections.cpp: see reflections.h.
#include "render/light/reflections.h"

#include "core/base/error.h"
#include "core/base/progress.h"
#include "core/base/threads.h"
#include "render/contract/lattice.h"
#include "render/contract/optics.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <utility>

namespace tessera {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kTogether = 16384, kLeast = 64; // rays of an order that are followed together
constexpr std::size_t kRaysOfTask = 64;               // of a thread's task
constexpr float kFaint = 1.0f / 255;                  // factors below are not followed
constexpr double kSteepest = 0.25;                    // cosine; flatter ways begin as near as one of it

} // namespace

glm::dvec3 mirroredDirection(const glm::dvec3& direction, const glm::dvec3& normal) {
    return direction - 2 * glm::dot(direction, normal) * normal;
}

std::optional<glm::dvec3> refractedDirection(const glm::dvec3& direction, const glm::dvec3& normal,
                                             double eta) {
    const double c = -glm::dot(direction, normal), k = 1 - eta * eta * (1 - c * c);
    if (!(k >= 0))
        return std::nullopt;
    return glm::normalize(eta * direction + (eta * c - std::sqrt(k)) * normal);
}

double dielectricShare(double cosine, double eta) {
    const double k = 1 - eta * eta * (1 - cosine * cosine);
    if (!(k >= 0))
        return 1;
    const double behind = std::sqrt(k);
    const double s = (eta * cosine - behind) / (eta * cosine + behind),
                 p = (eta * behind - cosine) / (eta * behind + cosine);
    return std::min(1.0, 0.5 * (s * s + p * p));
}

Reflections::Reflections(const FramePlan& plan, int threads, bool finestSamples)
    : plan_(plan), threads_(threads), finestSamples_(finestSamples),
      most_(plan.view.lighting.reflectionOrder),
      together_(std::clamp(rayCount(plan.view.imageSize), kLeast, kTogether)),
      toVoxels_(glm::inverse(glm::dmat3(plan.info().patientFromVoxel))),
      toPatient_(plan.info().patientFromVoxel) {
    TESSERA_CHECK(plan.view.reflects);
    if (finestSamples) {
        finest_ = plan.layer().selection;
        std::fill(finest_.levels.begin(), finest_.levels.end(), std::uint8_t{0});
        finest_.counts = {finest_.levels.size()};
    }
    if (plan.view.lighting.environment) {
        Lighting lighting = plan.view.lighting;
        lighting.transport.emplace();
        sky_ = pathScene(lighting, plan.view.camera, plan.info(), plan.layer().optics,
                         plan.layer().extinction, nullptr, 0);
    }
}

std::size_t Reflections::bytes(const glm::ivec2& imageSize, bool sampled) {
    // Rays and ways of every order are there together, a slice of each; colours and hits of one; the picture
    // to add, with several samples its sums besides, and the hits of an array.
    const std::size_t together = std::clamp(rayCount(imageSize), kLeast, kTogether);
    const std::size_t ofOrders = Lighting::kMostReflections * 5 * together * sizeof(Ray),
                      ofDrawing = 4 * together * (sizeof(LightWay) + sizeof(glm::vec4) + sizeof(SurfaceHit));
    return ofOrders + ofDrawing +
           rayCount(imageSize) * (sizeof(SurfaceHit) + (sampled ? 4 : 1) * sizeof(glm::vec4));
}

bool Reflections::reflectsAt(const SurfaceHit& hit) const {
    return hit.surface != 0 && hit.normal != glm::vec3(0) &&
           plan_.layer().optics.surfaces[static_cast<std::size_t>(hit.surface) - 1].reflection;
}

glm::dvec3 Reflections::directionAt(const glm::vec2& place) const {
    return glm::normalize(toPatient_ * pixelLine(plan_.view.frame, glm::dvec2(place)).direction);
}

/// The ways of a ray that is at a surface.
template <typename Field> Reflections::Leaving Reflections::leave(const Ray& ray, Field& field) const {
    const Optics& optics = plan_.layer().optics;
    const std::size_t number = static_cast<std::size_t>(ray.hit.surface) - 1;
    const SurfaceLook& look = optics.surfaces[number];
    const Reflection& reflection = *look.reflection;
    const glm::dvec3 normal = glm::normalize(glm::dvec3(ray.hit.normal)), place(ray.hit.position);
    const glm::dvec3 pitch = pitchAlong(plan_, place, toVoxels_ * normal, finestSamples_);
    const double pitchMm = glm::length(toPatient_ * pitch);
    const double cosine = std::clamp(-glm::dot(ray.direction, normal), 0.0, 1.0);

    double eta = 1;
    if (reflection.transmits || reflection.kind == ReflectionKind::fresnel) {
        // Stored values fall where a slope is negative, and the surfaces are by stored values.
        const int rising = plan_.info().rescaleSlope < 0 ? -1 : 1;
        const float rise = field.value(glm::vec3(place - pitch)) - field.value(glm::vec3(place + pitch));
        const bool enters = static_cast<float>(rising) * rise > 0;
        auto lower = static_cast<std::ptrdiff_t>(number) - rising;
        const auto there = [&](std::ptrdiff_t n) { return n >= 0 && n < std::ssize(optics.surfaces); };
        while (there(lower) && optics.surfaces[static_cast<std::size_t>(lower)].isovalue == look.isovalue)
            lower -= rising;
        const Reflection* const below =
            there(lower) && optics.surfaces[static_cast<std::size_t>(lower)].reflection
                ? &*optics.surfaces[static_cast<std::size_t>(lower)].reflection
                : nullptr;
        eta = (below ? below->ior : 1) / reflection.ior;
        eta = enters ? eta : 1 / eta;
    }
    double share = reflection.strength;
    if (reflection.kind == ReflectionKind::fresnel) {
        share *= dielectricShare(cosine, eta);
    } else if (reflection.kind == ReflectionKind::gradient) {
        const glm::vec3 gradient =
            inPatient<float>(optics.voxelFromPatientTransposed, field.gradient(ray.hit.position));
        const double steep = double{glm::length(gradient)} * std::abs(plan_.info().rescaleSlope),
                     low = reflection.gradient.low, high = reflection.gradient.high;
        const double t = high > low ? std::clamp((steep - low) / (high - low), 0.0, 1.0) : steep >= low;
        share *= t * t * (3 - 2 * t);
    }
    const double opacity = double{look.own};
    const auto bent =
        reflection.transmits ? refractedDirection(ray.direction, normal, eta) : std::optional<glm::dvec3>();
    double through = 0;
    if (!reflection.transmits)
        share *= opacity;
    else if (bent)
        through = (1 - share) * (1 - opacity);
    else
        share = 1;
    const auto way = [&](double part, const glm::dvec3& direction) {
        std::optional<Ray> out;
        const float factor = ray.factor * ray.hit.weight * static_cast<float>(part);
        if (factor >= kFaint) {
            const double steepness = std::max(std::abs(glm::dot(direction, normal)), kSteepest);
            const glm::dvec3 from = place + toVoxels_ * direction * (pitchMm / steepness);
            out = Ray{ray.pixel, factor, direction, {}, from, pitchMm};
        }
        return out;
    };
    Leaving leaving;
    leaving.mirrored = way(share, mirroredDirection(ray.direction, normal));
    if (bent)
        leaving.refracted = way(through, *bent);
    return leaving;
}

/// The ways of rays at surfaces, in order.
std::vector<Reflections::Ray> Reflections::waysFrom(std::span<const Ray> rays) const {
    std::vector<Leaving> all(rays.size());
    const Layer& layer = plan_.layer();
    parallelFor((rays.size() + kRaysOfTask - 1) / kRaysOfTask, threads_, [&](std::size_t strip) {
        withCacheField<float>(*layer.cache, plan_.info(), finestSamples_ ? finest_ : layer.selection,
                              !finestSamples_ && layer.mixed() ? &layer.levels : nullptr,
                              layer.optics.gradient, [&](auto& field) {
                                  for (std::size_t n = strip * kRaysOfTask;
                                       n < std::min(rays.size(), (strip + 1) * kRaysOfTask); ++n)
                                      all[n] = leave(rays[n], field);
                              });
    });
    std::vector<Ray> ways;
    ways.reserve(2 * all.size());
    for (const Leaving& leaving : all)
        for (const std::optional<Ray>* way : {&leaving.mirrored, &leaving.refracted})
            if (*way)
                ways.push_back(**way);
    return ways;
}

/// Adds the ways' colours to the picture.
/// Returns those that met another such surface, there.
std::vector<Reflections::Ray> Reflections::follow(std::span<const Ray> ways, const Draw& draw,
                                                  Image& out) const {
    std::vector<WayPart> parts;
    std::vector<std::size_t> first = {0};
    for (const Ray& way : ways) {
        addWayParts(plan_.view.frame, way.from, toVoxels_ * way.direction, std::numeric_limits<double>::max(),
                    parts);
        first.push_back(parts.size());
    }
    std::vector<LightWay> of(parts.size());
    std::transform(parts.begin(), parts.end(), of.begin(), [](const WayPart& part) { return part.way; });
    std::vector<glm::vec4> colours(parts.size());
    std::vector<SurfaceHit> hits(parts.size());
    if (!parts.empty())
        draw(of, colours, hits);
    std::vector<Ray> met;
    met.reserve(ways.size());
    for (std::size_t n = 0; n < ways.size(); ++n) {
        const Ray& way = ways[n];
        glm::vec3 colour(0);
        float left = 1;
        bool meets = false;
        for (std::size_t part = first[n]; part < first[n + 1]; ++part) {
            SurfaceHit& hit = hits[part];
            if (!meets && hit.surface != 0) {
                meets = true;
                hit.weight *= left;
                if (reflectsAt(hit)) {
                    met.push_back({way.pixel, way.factor, way.direction, hit, {}, 0});
                    const glm::dvec3 gone = toPatient_ * (glm::dvec3(hit.position) - way.from);
                    report_.near += glm::length(gone) < 2 * way.pitchMm ? 1 : 0;
                }
            }
            colour += left * glm::vec3(colours[part]);
            left *= 1 - colours[part].a;
        }
        const glm::vec3 beyond = sky_ ? skyFrom(*sky_, glm::vec3(way.direction)) : plan_.view.background;
        out.pixels[way.pixel] += glm::vec4(way.factor * (colour + left * beyond), 0);
    }
    report_.met += met.size();
    return met;
}

/// @param rays  at surfaces
/// @param order  of the ways that leave them
void Reflections::followAll(std::vector<Ray> rays, int order, const Draw& draw, Image& out) const {
    for (std::size_t from = 0; from < rays.size(); from += together_) {
        const std::size_t count = std::min(together_, rays.size() - from);
        std::vector<Ray> ways = waysFrom(std::span(rays).subspan(from, count));
        report_.ways[static_cast<std::size_t>(order) - 1] += ways.size();
        std::vector<Ray> met = follow(ways, draw, out);
        ways = {};
        if (order < most_)
            followAll(std::move(met), order + 1, draw, out);
    }
}

Image Reflections::added(std::span<const SurfaceHit> hits, std::span<const glm::vec2> places,
                         const glm::ivec2& size, const Draw& draw) const {
    TESSERA_CHECK(hits.size() == rayCount(size) && (places.empty() || places.size() == hits.size()));
    const auto start = Clock::now();
    Image out(size);
    const auto width = static_cast<std::size_t>(size.x);
    std::vector<Ray> rays;
    for (std::size_t n = 0; n < hits.size(); ++n) {
        if (reflectsAt(hits[n])) {
            const glm::vec2 place =
                places.empty()
                    ? glm::vec2(static_cast<float>(n % width), static_cast<float>(n / width)) + 0.5f
                    : places[n];
            rays.push_back({n, 1, directionAt(place), hits[n], {}, 0});
        }
        if (rays.size() == together_ || n + 1 == hits.size())
            followAll(std::exchange(rays, {}), 1, draw, out);
    }
    report_.seconds += secondsSince(start);
    return out;
}

} // namespace tessera
