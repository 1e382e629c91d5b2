// render/light/scene_light.cpp: see scene_light.h.
#include "render/light/scene_light.h"

#include "core/error.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <utility>

namespace tessera {
namespace {

constexpr std::uint32_t kEntryValue = 0x80000000u, kEntryAbsent = 0x40000000u; // brick_residency.h

std::vector<PlacedLight> placedLights(const ScenePlan& scene) {
    std::vector<PlacedLight> placed;
    for (const Light& light : castingLights(scene.view.lighting.lights))
        placed.push_back(placedLight(light, scene.view.camera));
    return placed;
}

} // namespace

SceneLight::SceneLight(const ScenePlan& scene, int threads) : scene_(scene), threads_(threads) {
    TESSERA_CHECK(channels() > 0);
}

void SceneLight::viewChanged() {
    for (const Light& light : castingLights(scene_.view.lighting.lights))
        if (light.frame == LightFrame::camera)
            shadowsAreNew_ = true;
}

/// Integrators come and go by the same way as functions, and change no light.
void SceneLight::lookAtFunction() {
    if (std::exchange(functionMayBeNew_, false) && litTable_ != scene_.volume.optics.table) {
        litTable_ = scene_.volume.optics.table;
        shadowsAreNew_ = functionIsNew_ = true;
    }
}

bool SceneLight::takeChanges() {
    lookAtFunction();
    if (shadowsAreNew_ || functionIsNew_)
        ready();
    return std::exchange(changed_, false);
}

VoxelLight& SceneLight::ready() {
    lookAtFunction();
    const VolumeState& volume = scene_.volume;
    if (shadowsAreNew_) {
        const LightPath field{volume.cache.get(), &scene_.info(),
                              &volume.selection,  volume.mixed() ? &volume.levels : nullptr,
                              &volume.optics,     scene_.view.quality.skipping ? &volume.occupancy : nullptr};
        const std::vector<PlacedLight> lights = placedLights(scene_);
        if (!lights.empty() || !light_) {
            light_.reset();
            shadows_.clear();
            for (const PlacedLight& light : lights) {
                shadows_.emplace_back(light, field, scene_.view.shadowQuality);
                shadows_.back().build(field, threads_);
            }
            light_.emplace(scene_.info(), volume.statistics, scene_.view.lighting, shadows_, threads_);
            functionIsNew_ = true;
        }
        shadowsAreNew_ = false;
    }
    if (functionIsNew_) {
        light_->functionChanged(volume.table, volume.optics);
        functionIsNew_ = false;
        changed_ = true;
    }
    return *light_;
}

LightReport SceneLight::report(std::size_t planeBytes) const {
    LightReport report;
    report.channels = channels();
    report.planeBytes = planeBytes;
    report.seconds = seconds_;
    report.emission = ambientChannels(scene_.view.lighting) > 1;
    std::size_t more = 0, rays = 0;
    for (const ShadowMaps& shadow : shadows_)
        for (const DeepShadowMap& map : shadow.maps()) {
            ++report.maps;
            report.mapSize = map.size();
            report.mapBytes += DeepShadowMap::bytes(map.size());
        }
    for (const ShadowMaps& shadow : shadows_) {
        const std::size_t of = shadow.maps().size();
        more += static_cast<std::size_t>(shadow.shareOfMore() * 1e6) * of;
        rays += of;
        report.mapError = std::max(report.mapError, shadow.largestError());
    }
    report.shareOfMore = rays == 0 ? 0 : 1e-6 * static_cast<double>(more) / static_cast<double>(rays);
    return report;
}

LightPlane::LightPlane(SceneLight& light, const ScenePlan& scene, std::vector<Plane*> channels)
    : light_(light), scene_(scene), channels_(std::move(channels)),
      entries_(cellCount(brickGrid(scene.info().extentVoxels)), BrickEntry(kEntryAbsent, 0)),
      slots_(entries_.size()), isLit_(entries_.size(), 0) {}

void LightPlane::put(const AtlasSlot& slot, const BrickSamples& samples, Work&) {
    slots_[samples.brick] = slot;
    isLit_[samples.brick] = 0;
}

void LightPlane::publish(std::span<const BrickEntry> entries) {
    std::copy(entries.begin(), entries.end(), entries_.begin());
    published_ = true;
}

void LightPlane::settle(Work& work) {
    const auto start = std::chrono::steady_clock::now();
    if (light_.takeChanges()) {
        std::fill(isLit_.begin(), isLit_.end(), std::uint8_t{0});
        published_ = true;
    }
    if (!published_)
        return;
    VoxelLight& light = light_.ready();
    std::vector<BrickToLight> bricks;
    for (std::size_t b = 0; b < entries_.size(); ++b)
        if ((entries_[b].x & (kEntryValue | kEntryAbsent)) == 0 && !isLit_[b]) {
            bricks.push_back({b, slots_[b]->level});
            isLit_[b] = 1;
        }
    BrickCache& cache = *scene_.volume.cache;
    light.light(std::move(bricks), cache,
                [&](const BrickToLight& b, int channel, const Chunk& samples, int edge) {
                    channels_[static_cast<std::size_t>(channel)]->put(
                        *slots_[b.brick], {samples, glm::ivec3(0), edge, b.brick}, work);
                });
    std::vector<BrickEntry> entries = entries_;
    for (std::size_t c = 0; c < channels_.size(); ++c) {
        for (std::size_t b = 0; b < entries.size(); ++b)
            if ((entries_[b].x & kEntryValue) != 0)
                entries[b].y = std::bit_cast<std::uint32_t>(
                    static_cast<float>(light.standing(b, static_cast<int>(c), cache)));
        channels_[c]->finish();
        channels_[c]->publish(entries);
    }
    published_ = false;
    light_.took(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
}

} // namespace tessera
