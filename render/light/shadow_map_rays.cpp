// render/light/shadow_map_rays.cpp: the rays of shadow maps and of light maps: see shadow_maps.h.
#include "render/light/shadow_maps.h"

#include "core/base/threads.h"
#include "render/contract/lattice.h"
#include "render/light/light_sweep.h"
#include "render/light/mesh_shade.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <optional>

namespace tessera {
namespace {

constexpr double kFarMm = 1e7;     // beyond every mesh
constexpr float kDarkest = 1e-30f; // rays of light maps end below it: what is dark has depth, too

/// A field with its labels.
template <typename Values> struct ShadowedField {
    Values& values;
    std::optional<LabelField> shares;
    float value(const glm::vec3& p) { return values.value(p); }
    glm::vec3 gradient(const glm::vec3& p) { return values.gradient(p); }
    leaf::LabelShares<float> labels(const glm::vec3& p) { return shares->shares(p); }
};

} // namespace

ShadowMaps::Row ShadowMaps::rowOf(const VolumeInfo& info, const View& view, int size, int y) const {
    const RayFrame<float> frame = cast<float>(rayFrame(view.camera, info, {size, size}, quality_.stepVoxels));
    Row row;
    for (int x = 0; x < size; ++x) {
        row.rays.push_back(
            segmentedRay(frame, glm::vec2(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f)));
        const glm::dvec3 entry(info.patientFromVoxel * glm::dvec4(glm::dvec3(row.rays.back().entry), 1));
        row.entries.push_back(static_cast<float>(
            view.plane.perspective ? glm::length(entry - view.camera.position)
                                   : glm::dot(entry - view.plane.centre, view.plane.forward)));
    }
    return row;
}

/// Surfaces of meshes along a ray of a map, in its distances.
std::vector<ShadeStep> ShadowMaps::shadesOf(const LightPath& field, const View& view, const glm::dvec2& pixel,
                                            int size) const {
    std::vector<ShadeStep> steps;
    const PatientRay ray = pixelRay(view.plane, pixel, glm::ivec2(size));
    const double eye = view.plane.perspective ? ray.minT : 0; // mm count from there, or from the plane
    shadeSteps(field.meshes, {ray.base, ray.direction}, std::max(ray.minT, -kFarMm), kFarMm, steps);
    for (ShadeStep& step : steps)
        step.t -= eye;
    return steps;
}

/// Finds the light left along a row's rays.
/// @param visit  gets the number of a ray, and its samples
template <typename Visit>
void ShadowMaps::castRow(const LightPath& field, const Row& row, float dark, const Visit& visit) const {
    const std::vector<SegmentedRay<float>>& rays = row.rays;
    const std::vector<float>& entries = row.entries;
    std::size_t done = 0;
    if (field.rays) {
        std::vector<LightLeft> room;
        std::vector<std::span<const LightLeft>> samples(field.rays->mostAtOnce());
        while (done < rays.size()) {
            const std::size_t count = std::min(samples.size(), rays.size() - done);
            if (!field.rays->along(std::span(rays).subspan(done, count),
                                   std::span(entries).subspan(done, count), dark, room,
                                   std::span(samples).first(count)))
                break;
            for (std::size_t r = 0; r < count; ++r)
                visit(done + r, samples[r]);
            done += count;
        }
    }
    if (done == rays.size())
        return;
    Strides strides;
    strides.map = field.levels;
    strides.uniformSegments = 1;
    strides.segmentVoxels = quality_.stepVoxels;
    std::vector<LightLeft> samples;
    withCacheField<float>(
        *field.cache, *field.info, *field.selection, field.levels, field.optics->gradient, [&](auto& values) {
            ShadowedField<std::decay_t<decltype(values)>> shadowed{values, {}};
            if (field.labels)
                shadowed.shares.emplace(*field.labels, *field.selection, field.levels,
                                        field.info->extentVoxels);
            for (; done < rays.size(); ++done) {
                lightAlong(rays[done], shadowed, field, strides, entries[done], samples, dark);
                visit(done, std::span<const LightLeft>(samples));
            }
        });
}

/// @param more, largest  number of rays with a larger error bound than requested; the largest bound
void ShadowMaps::buildRow(const LightPath& field, std::size_t row, std::size_t& more, float& largest) {
    const int size = size_;
    const std::size_t n = row / static_cast<std::size_t>(size);
    const View& view = views_[n];
    const int y = static_cast<int>(row) % size;
    std::vector<LightLeft> shaded;
    castRow(field, rowOf(*field.info, view, size, y), DeepShadowMap::kDark,
            [&](std::size_t x, std::span<const LightLeft> samples) {
                if (!field.meshes.empty()) {
                    const glm::dvec2 pixel(static_cast<double>(x) + 0.5, y + 0.5);
                    shadeSamples(samples, shadesOf(field, view, pixel, size), shaded);
                    samples = shaded;
                }
                const float error = maps_[n]->fit({static_cast<int>(x), y}, samples, quality_.error);
                largest = std::max(largest, error);
                more += error > quality_.error ? 1 : 0;
            });
}

/// @param row  of those of all light maps
void ShadowMaps::buildLightRow(const LightPath& field, std::size_t row) {
    const LightGrid& grid = lightMaps_.front()->grid();
    const std::size_t n = row / static_cast<std::size_t>(grid.size);
    const View& view = views_[n];
    const LightGrid& mine = lightMaps_[n]->grid();
    const int y = static_cast<int>(row) % grid.size;
    const Row rays = rowOf(*field.info, view, grid.size, y);
    std::vector<LightSlice> slices(static_cast<std::size_t>(mine.slices));
    withCacheField<float>(
        *field.cache, *field.info, *field.selection, field.levels, field.optics->gradient, [&](auto& values) {
            castRow(field, rays, kDarkest, [&](std::size_t x, std::span<const LightLeft> samples) {
                const SegmentedRay<float>& ray = rays.rays[x];
                std::fill(slices.begin(), slices.end(), LightSlice{});
                for (std::size_t s = 1; s < samples.size(); ++s) {
                    const LightLeft &a = samples[s - 1], &b = samples[s];
                    if (!(b.light < a.light))
                        continue;
                    const float depth = b.light > 0 ? std::log(a.light / b.light) : kOpaqueDepth;
                    const float at = (0.5f * (a.mm + b.mm) - rays.entries[x]) / ray.segmentMm;
                    addToSlices(mine, a.mm, b.mm, std::min(depth, kOpaqueDepth),
                                occlusionAlbedo(*field.optics, values.value(ray.entry + at * ray.step)),
                                slices);
                }
                if (!field.meshes.empty()) {
                    const glm::dvec2 pixel(static_cast<double>(x) + 0.5, y + 0.5);
                    for (const ShadeStep& step : shadesOf(field, view, pixel, grid.size)) {
                        const auto mm = static_cast<float>(step.t);
                        const auto through = static_cast<float>(1 - step.opacity);
                        addToSlices(mine, mm, mm,
                                    through > 0 ? std::min(-std::log(through), kOpaqueDepth) : kOpaqueDepth,
                                    glm::vec3(0), slices);
                    }
                }
                const bool ended = !samples.empty() && samples.back().light < kDarkest;
                finishSlices(mine, ended ? samples.back().mm : -1, slices);
                sweep_->setRay({static_cast<int>(x), y}, slices);
            });
        });
}

std::size_t ShadowMaps::rows() const {
    return mapRows() + (lightMaps_.empty()
                            ? 0
                            : lightMaps_.size() * static_cast<std::size_t>(lightMaps_.front()->grid().size));
}

/// Casts rays of rows of one map: first those of all shadow maps, then those of each light map; or lets light
/// cross slices of one that has all.
void ShadowMaps::buildSome(const LightPath& field, int threads, std::size_t most, const ShareDone& progress) {
    const std::size_t before = rowsBuilt_, first = mapRows();
    if (before < first) {
        const std::size_t count = std::min(most, first - before);
        std::mutex mutex;
        parallelFor(
            count, threads,
            [&](std::size_t n) {
                std::size_t more = 0;
                float largest = 0;
                buildRow(field, before + n, more, largest);
                const std::lock_guard lock(mutex);
                largestError_ = std::max(largestError_, largest);
                more_ += more;
            },
            progress);
        rowsBuilt_ += count;
        if (rowsBuilt_ == first)
            finish();
        return;
    }
    const auto size = static_cast<std::size_t>(lightMaps_.front()->grid().size);
    const std::size_t done = before - first;
    if (sweep_ && done % size == 0) { // its rays are cast
        if (sweep_->cross(static_cast<int>(most), threads, *lightMaps_[done / size - 1]))
            sweep_.reset();
        return;
    }
    if (!sweep_)
        sweep_ = std::make_shared<MapSweep>(lightMaps_[done / size]->grid(), quality_.lightMap->g);
    const std::size_t count = std::min(most, size - done % size);
    parallelFor(count, threads, [&](std::size_t n) { buildLightRow(field, done + n); });
    rowsBuilt_ += count;
}

void ShadowMaps::build(const LightPath& field, int threads, const ShareDone& progress) {
    while (!isBuilt())
        buildSome(field, threads, rows(), progress);
}

void ShadowMaps::finish() {
    for (const std::shared_ptr<ShadowMap>& map : maps_)
        map->finish();
}

bool ShadowMaps::buildUntil(const LightPath& field, int threads,
                            std::chrono::steady_clock::time_point deadline) {
    constexpr std::size_t kRowsAtATime = 8;
    while (!isBuilt()) {
        buildSome(field, threads, kRowsAtATime, {});
        if (std::chrono::steady_clock::now() >= deadline)
            break;
    }
    return isBuilt();
}

} // namespace tessera
