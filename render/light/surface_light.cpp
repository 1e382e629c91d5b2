// render/light/surface_light.cpp: see surface_light.h.
#include "render/light/surface_light.h"

#include "core/base/error.h"
#include "core/base/progress.h"
#include "core/base/threads.h"
#include "render/contract/optics.h"
#include "render/geometry/shape.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <chrono>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <numbers>

namespace tessera {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kStrip = 16; // points per task of a thread
constexpr double kGoldenAngle = 2.399963229728653;
constexpr int kWindow = 3;           // half width of the filter, pixels
constexpr int kCoarseWindow = 2;     // the same between pixels that are looked at, in their distances
constexpr float kReachParts = 4;     // they lie within one such part of the radius,
constexpr float kLevelParts = 4;     // and within such a part of that of each other's tangent planes
constexpr float kApart = 0.8f;       // difference of results that counts as equal, in errors of one direction
constexpr float kEnough = 1.0f / 64; // least weight of a sample's neighbours, in equal points

} // namespace

std::uint64_t hemisphereKey(const glm::vec2& place, std::uint32_t seed) {
    const std::uint64_t at =
        std::uint64_t{std::bit_cast<std::uint32_t>(place.x)} << 32 | std::bit_cast<std::uint32_t>(place.y);
    return mixedBits(mixedBits(at) + seed);
}

/// A sunflower pattern on a disk, with equal areas, lifted to the hemisphere.
std::vector<glm::dvec3> hemisphereDirections(const glm::dvec3& normal, int count, std::uint64_t key) {
    const double turn = 2 * std::numbers::pi * unitFraction(mixedBits(key)),
                 shift = unitFraction(mixedBits(key + 1));
    // An orthonormal frame without a branch (Duff et al. 2017).
    const double sign = std::copysign(1.0, normal.z);
    const double a = -1 / (sign + normal.z), b = normal.x * normal.y * a;
    const glm::dvec3 across(1 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x);
    const glm::dvec3 along(b, sign + normal.y * normal.y * a, -normal.y);
    std::vector<glm::dvec3> directions;
    directions.reserve(static_cast<std::size_t>(count));
    for (int k = 0; k < count; ++k) {
        const double squared = (k + shift) / count, angle = turn + k * kGoldenAngle;
        const double radius = std::sqrt(squared);
        directions.push_back(radius * std::cos(angle) * across + radius * std::sin(angle) * along +
                             std::sqrt(1 - squared) * normal);
    }
    return directions;
}

/// A sample may lie outside its pixel, as far as filters of pixels reach (render/pixels/pixel_places.h).
int SurfaceLight::margin(const SurfaceOcclusion& occlusion) {
    return (occlusion.scale > 1 ? kCoarseWindow * occlusion.scale : kWindow) + 2;
}

SurfaceLight::SurfaceLight(const FramePlan& plan, int threads, bool finestSamples,
                           const std::optional<PictureTile>& part)
    : plan_(plan), threads_(threads), finestSamples_(finestSamples), seed_(plan.view.quality.pixels.seed),
      from_(part ? part->from : glm::ivec2(0)), size_(part ? part->size : plan.view.imageSize),
      toVoxels_(glm::inverse(glm::dmat3(plan.info().patientFromVoxel))),
      toPatient_(plan.info().patientFromVoxel) {
    TESSERA_CHECK(plan.view.lighting.surfaceOcclusion);
    occlusion_ = *plan.view.lighting.surfaceOcclusion;
    const Optics& optics = plan.layer().optics;
    volumeTakes_ = optics.volumeShows || !optics.surfaces.empty();
    isosurfaces_ = static_cast<int>(optics.surfaces.size());
    if (plan.view.meshBits)
        meshes_.emplace(*plan.view.meshBits, occlusion_.threshold);
    report_.rays = occlusion_.rays;
    report_.radiusMm = occlusion_.radiusMm;
}

std::size_t SurfaceLight::bytesPerPixel(bool sampled, bool meshes) {
    // Hits and results of pixel centres, and their keys; the colours to add to an array of rays, and to the
    // picture. With several samples per pixel: the hits of an array, and the sums of the colours to add.
    // Of rays that meet meshes, both with the hits.
    const std::size_t middles = sizeof(SurfaceHit) + sizeof(float) + sizeof(glm::vec4);
    return (sampled ? middles + sizeof(SurfaceHit) + 3 * sizeof(glm::vec4) : middles) +
           (meshes ? 2 * (sizeof(SurfaceHit) + sizeof(glm::vec3)) : 0);
}

/// Where a hit lies on its mesh, without the rounding of its place, and the normal of the triangle there.
/// Found anew, by a ray from a little above; where that meets nothing, as the hit has them.
SurfaceLight::MeshPlace SurfaceLight::onMesh(const SurfaceHit& hit) const {
    constexpr double kRounding =
        0x1p-20; // of a place's numbers, which are floats: 16 halves of their last bit
    const glm::dvec3 voxel(hit.position), normal(hit.normal);
    MeshPlace found{glm::dvec3(plan_.info().patientFromVoxel * glm::dvec4(voxel, 1)), normal};
    const double far = std::max({std::abs(voxel.x), std::abs(voxel.y), std::abs(voxel.z), 1.0}),
                 pitch = std::max(
                     {glm::length(toPatient_[0]), glm::length(toPatient_[1]), glm::length(toPatient_[2])}),
                 above = kRounding * far * pitch;
    const Shape& shape = *plan_.view.meshes[static_cast<std::size_t>(hit.surface - isosurfaces_ - 1)].shape;
    const ShapeRay ray{found.place + above * normal, -normal};
    double nearest = above;
    HitOrder after{0, 0};
    for (ShapeHit met; shape.next(ray, after, 2 * above, {}, met); after = met.at) {
        const glm::dvec3 own = met.plane == glm::dvec3(0) ? met.normal : met.plane;
        const double length = glm::length(own), off = std::abs(met.at.t - above);
        if (!(length > 0) || !(off <= nearest))
            continue;
        nearest = off;
        found = {ray.origin + met.at.t * ray.direction, own / (glm::dot(own, normal) < 0 ? -length : length)};
    }
    return found;
}

/// The rays of a point, up to where they meet meshes, clipped to the picture's cuts.
void SurfaceLight::addWays(const SurfaceHit& hit, std::uint64_t key, Ways& all) const {
    const glm::dvec3 normal(hit.normal), place(hit.position);
    const glm::dvec3 from = place + pitchAlong(plan_, place, toVoxels_ * normal, finestSamples_);
    const bool isMesh = hit.surface > isosurfaces_;
    const MeshPlace start =
        isMesh && meshes_
            ? onMesh(hit)
            : MeshPlace{glm::dvec3(plan_.info().patientFromVoxel * glm::dvec4(from, 1)), normal};
    std::vector<WayPart> parts;
    int number = 0;
    for (const glm::dvec3& direction : hemisphereDirections(normal, occlusion_.rays, key)) {
        double reach = occlusion_.radiusMm;
        const double cosine = isMesh ? glm::dot(direction, start.normal) : 0;
        // Of a bent normal some ways lie behind the surface: they meet no mesh.
        const double first = !meshes_ || !isMesh ? 0 : cosine > 0 ? meshes_->guardedStart(cosine) : reach;
        if (meshes_ && first < reach)
            reach = meshes_->reach(start.place, direction, first, reach,
                                   key + 2 * static_cast<unsigned>(number) + 2, cosine);
        all.reach.push_back(reach);
        parts.clear();
        if (volumeTakes_)
            addWayParts(plan_.view.frame, from, toVoxels_ * direction, reach, parts);
        for (const WayPart& part : parts)
            all.ways.push_back({part, number});
        ++number;
    }
}

/// For each point the mean over directions of the light left along the ray, averaged over its length.
void SurfaceLight::openAround(std::span<const SurfaceHit> hits, std::span<const std::uint64_t> keys,
                              const SurfaceTracer& tracer, std::span<float> open) const {
    Ways all;
    std::vector<std::size_t> first = {0};
    for (std::size_t n = 0; n < hits.size(); ++n) {
        addWays(hits[n], keys[n], all);
        first.push_back(all.ways.size());
    }
    std::vector<LightWay> of(all.ways.size());
    std::transform(all.ways.begin(), all.ways.end(), of.begin(), [](const Way& w) { return w.part.way; });
    std::vector<LightTaken> taken(all.ways.size());
    if (!of.empty())
        tracer.trace(of, taken);
    const double* reach = all.reach.data();
    for (std::size_t n = 0; n < hits.size(); ++n) {
        double lost = 0;
        std::size_t w = first[n];
        for (int number = 0; number < occlusion_.rays; ++number, ++reach) {
            double left = 1;
            for (; w < first[n + 1] && all.ways[w].direction == number; ++w) {
                const double mm = static_cast<double>(taken[w].mm),
                             part = static_cast<double>(taken[w].taken);
                lost += left * (part - (mm + all.ways[w].part.beginMm * part) / occlusion_.radiusMm);
                left *= 1 - part;
            }
            if (*reach < occlusion_.radiusMm) // a mesh takes the rest
                lost += left * (1 - *reach / occlusion_.radiusMm);
        }
        open[n] = static_cast<float>(std::clamp(1 - lost / occlusion_.rays, 0.0, 1.0));
    }
}

float SurfaceLight::openAt(const SurfaceHit& hit, const glm::vec2& place, const SurfaceTracer& tracer) const {
    float open = 1;
    const std::uint64_t key = hemisphereKey(place, seed_);
    if (hit.surface != 0 && hit.normal != glm::vec3(0))
        openAround(std::span(&hit, 1), std::span(&key, 1), tracer, std::span(&open, 1));
    return open;
}

glm::vec2 SurfaceLight::placeOf(std::size_t pixel) const {
    const auto width = static_cast<std::size_t>(size_.x);
    return glm::vec2(from_) +
           glm::vec2(static_cast<float>(pixel % width), static_cast<float>(pixel / width)) + 0.5f;
}

std::size_t SurfaceLight::pixelAt(const glm::ivec2& pixel) const {
    return static_cast<std::size_t>(pixel.y) * static_cast<std::size_t>(size_.x) +
           static_cast<std::size_t>(pixel.x);
}

/// The first pixel from one on that is looked at, whatever part of the picture this is.
glm::ivec2 SurfaceLight::lookedFrom(const glm::ivec2& pixel) const {
    const int scale = occlusion_.scale;
    const glm::ivec2 past = (from_ + pixel + (scale - scale / 2)) % scale;
    return pixel + (scale - past) % scale;
}

void SurfaceLight::look(std::vector<SurfaceHit> middles, const SurfaceTracer& tracer,
                        const ShareDone& progress) {
    TESSERA_CHECK(middles.size() == rayCount(size_));
    const auto start = Clock::now();
    middles_ = std::move(middles);
    open_.assign(middles_.size(), 1.0f);
    const glm::ivec2 low = lookedFrom(glm::ivec2(0)),
                     count =
                         glm::max((size_ - low + (occlusion_.scale - 1)) / occlusion_.scale, glm::ivec2(0));
    const std::size_t looked = rayCount(count);
    std::atomic<std::size_t> places{0};
    parallelFor((looked + kStrip - 1) / kStrip, threads_,
                [&](std::size_t strip) {
                    SurfaceHit hits[kStrip];
                    std::uint64_t keys[kStrip];
                    float open[kStrip];
                    std::size_t pixels[kStrip], found = 0;
                    for (std::size_t n = strip * kStrip; n < std::min(looked, (strip + 1) * kStrip); ++n) {
                        const auto across = static_cast<int>(n % static_cast<std::size_t>(count.x)),
                                   down = static_cast<int>(n / static_cast<std::size_t>(count.x));
                        const std::size_t i = pixelAt(low + occlusion_.scale * glm::ivec2(across, down));
                        if (middles_[i].surface != 0 && middles_[i].normal != glm::vec3(0)) {
                            hits[found] = middles_[i];
                            keys[found] = hemisphereKey(placeOf(i), seed_);
                            pixels[found++] = i;
                        }
                    }
                    openAround(std::span(hits).first(found), std::span(keys).first(found), tracer,
                               std::span(open).first(found));
                    for (std::size_t n = 0; n < found; ++n)
                        open_[pixels[n]] = open[n];
                    places += found;
                },
                progress);
    report_.places = places;
    report_.bytes = middles_.size() * (sizeof(SurfaceHit) + sizeof(float));
    report_.seconds += secondsSince(start);
}

/// The weighted mean of the results at pixel centres around a point, or below 0 if weights are negligible.
/// Weights fall with distance, difference of normals, and difference to the own pixel's result relative to
/// the error of directions.
float SurfaceLight::shared(const SurfaceHit& hit, const glm::ivec2& pixel) const {
    const float reach = static_cast<float>(occlusion_.radiusMm) / kReachParts, level = reach / kLevelParts;
    const float apart = kApart / std::pow(static_cast<float>(occlusion_.rays), 0.75f);
    const glm::mat3 toPatient(toPatient_);
    const auto weightOf = [&](const SurfaceHit& other) {
        if (other.surface != hit.surface)
            return 0.0f;
        const glm::vec3 away = toPatient * (other.position - hit.position);
        const float above = glm::dot(hit.normal, away), facing = glm::dot(hit.normal, other.normal);
        const float near = 1 - glm::dot(away, away) / (reach * reach);
        const float flat = 1 - above * above / (level * level);
        if (!(near > 0 && flat > 0 && facing > 0))
            return 0.0f;
        const float squared = facing * facing, fourth = squared * squared;
        return near * near * flat * flat * fourth * fourth;
    };
    const int scale = occlusion_.scale, window = scale > 1 ? kCoarseWindow * scale : kWindow;
    const std::size_t own = pixelAt(pixel);
    const bool knows = scale == 1 && weightOf(middles_[own]) > 0;
    float sum = 0, weights = 0;
    const glm::ivec2 low = lookedFrom(glm::max(pixel - window, glm::ivec2(0))),
                     high = glm::min(pixel + window, size_ - 1);
    for (int y = low.y; y <= high.y; y += scale)
        for (int x = low.x; x <= high.x; x += scale) {
            const std::size_t n = pixelAt({x, y});
            float weight = weightOf(middles_[n]);
            if (knows) {
                const float off = (open_[n] - open_[own]) / apart;
                const float alike = std::max(0.0f, 1 - off * off);
                weight *= alike * alike;
            }
            sum += weight * open_[n];
            weights += weight;
        }
    return weights > kEnough ? sum / weights : -1;
}

Image SurfaceLight::added(std::span<const SurfaceHit> hits, std::span<const glm::vec3> meshAmbient,
                          std::span<const glm::vec2> places, const glm::ivec2& size,
                          const SurfaceTracer& tracer) const {
    TESSERA_CHECK(hasLooked() && hits.size() == rayCount(size) &&
                  (places.empty() || places.size() == hits.size()) &&
                  (meshAmbient.empty() || meshAmbient.size() == hits.size()));
    const auto start = Clock::now();
    const Optics& optics = plan_.layer().optics;
    Image out(size);
    std::atomic<std::size_t> alone{0};
    parallelFor(static_cast<std::size_t>(size.y), threads_, [&](std::size_t row) {
        const auto width = static_cast<std::size_t>(size.x);
        for (std::size_t i = row * width; i < (row + 1) * width; ++i) {
            const SurfaceHit& hit = hits[i];
            if (hit.surface == 0 || hit.normal == glm::vec3(0))
                continue;
            const glm::vec2 place = places.empty() ? placeOf(i) : places[i];
            float open = -1;
            if (occlusion_.filter)
                open =
                    shared(hit, glm::clamp(glm::ivec2(glm::floor(place)) - from_, glm::ivec2(0), size_ - 1));
            else if (places.empty())
                open = open_[i];
            if (open < 0) {
                open = openAt(hit, place, tracer);
                ++alone;
            }
            if (hit.surface > isosurfaces_) {
                out.pixels[i] = glm::vec4(meshAmbient[i] * (hit.weight * (open - 1)), 0);
                continue;
            }
            const SurfaceLook& look = optics.surfaces[static_cast<std::size_t>(hit.surface) - 1];
            const float ambient = materialAt(optics, tessera::placeOf(optics, look.isovalue)).ambient;
            out.pixels[i] = glm::vec4(look.colour * (hit.weight * (look.opacity * ambient * (open - 1))), 0);
        }
    });
    report_.alone += alone;
    report_.seconds += secondsSince(start);
    return out;
}

} // namespace tessera
