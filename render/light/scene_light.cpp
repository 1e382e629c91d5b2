// render/light/scene_light.cpp: see scene_light.h.
#include "render/light/scene_light.h"

#include "core/base/error.h"

#include <algorithm>
#include <utility>

namespace tessera {
namespace {

/// Rays along a side of a coarse map, relative to a full one; of a light map, too.
constexpr int kCoarseMapPart = 4;

bool sameShadows(const std::vector<Light>& a, const std::vector<Light>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Light& x, const Light& y) {
        return x.kind == y.kind && x.frame == y.frame && x.direction == y.direction &&
               x.position == y.position && x.softness == y.softness;
    });
}

bool sameMaps(const ShadowMapping& a, const ShadowMapping& b) {
    return a.kind == b.kind && (a.kind == ShadowMapKind::deep || a == b);
}

/// True if light maps of both are of the same lights, and alike.
bool sameLightMaps(const Lighting& a, const Lighting& b) {
    if (!scattersByMaps(a) && !scattersByMaps(b))
        return true;
    const std::vector<Light> mine = castingLights(a.lights), other = castingLights(b.lights);
    return a.scatterBy == b.scatterBy && a.lightMap == b.lightMap &&
           std::equal(mine.begin(), mine.end(), other.begin(), other.end(),
                      [](const Light& x, const Light& y) { return (x.scatter > 0) == (y.scatter > 0); });
}

/// True if tissue scatters the lights of both alike.
bool scatterTheSame(const Lighting& a, const Lighting& b) {
    if (!scatters(a) && !scatters(b))
        return true;
    return a.scatterBy == b.scatterBy && a.scatterRadiusMm == b.scatterRadiusMm &&
           shiningLights(a.lights) == shiningLights(b.lights);
}

bool sendTheSame(const std::vector<leaf::MaterialNumbers>& a, const std::vector<leaf::MaterialNumbers>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& x, const auto& y) {
        return x.from == y.from && x.to == y.to && std::equal(x.emission, x.emission + 3, y.emission);
    });
}

/// True if tissue of both takes light alike, at every value: a function that is shifted has the same entries.
bool takeTheSame(const Optics& a, const Optics& b) {
    const auto& g = a.gradientOpacity;
    const auto& h = b.gradientOpacity;
    return a.table == b.table && a.scale == b.scale && a.offset == b.offset && g.count == h.count &&
           std::equal(g.length, g.length + g.count, h.length) &&
           std::equal(g.factor, g.factor + g.count, h.factor);
}

/// All visible bricks at one level.
Selection atOneLevel(const Selection& selection, int level) {
    Selection coarse = selection;
    coarse.counts = {};
    for (std::uint8_t& l : coarse.levels) {
        if (l != Selection::kEmpty)
            l = static_cast<std::uint8_t>(level);
        ++coarse.counts[l];
    }
    return coarse;
}

} // namespace

SceneLight::SceneLight(const FramePlan& scene, int threads) : scene_(scene), threads_(threads) {
    TESSERA_CHECK(channels() > 0);
    lightingChanged();
}

void SceneLight::viewChanged() {
    for (const Light& light : castingLights(lighting_.lights))
        if (light.frame == LightFrame::camera) {
            viewIsNew_ = true;
            next_.clear();
        }
}

void SceneLight::levelsChanged() {
    levelsAreNew_ = true;
    next_.clear();
}

LightParts SceneLight::lightingChanged() {
    const Lighting& now = scene_.view.lighting;
    const std::vector<Light> casting = castingLights(now.lights);
    LightParts changed = 0;
    if (!light_ || now.occlusion != lighting_.occlusion || now.finestLevel != lighting_.finestLevel ||
        !scatterTheSame(now, lighting_)) {
        const int before = light_ ? light_->finestLevel() : -1;
        light_ = std::make_unique<VoxelLight>(scene_.info(), scene_.layer().statistics, now, threads_,
                                              scene_.layer().histograms.get());
        light_->setLabels(scene_.layer().labels.get());
        takeMeshes();
        if (!lit_.table.empty())
            light_->functionChanged(scene_.layer().table, scene_.layer().optics);
        light_->setShadows(shadows_);
        tissueNumber_ = PlanRevisions::next();
        shadedBy_.clear();
        amidst_.clear();
        changed = light_->finestLevel() == before ? kAmbientLight : kAllLight;
    }
    if (!sameShadows(casting, castingLights(lighting_.lights)) ||
        !sameMaps(now.shadowMap, lighting_.shadowMap) || !sameLightMaps(now, lighting_)) {
        changed |= light_->partsByMaps();
        takeMaps({}, Maps::none);
    }
    next_.clear();
    lighting_ = now;
    casts_ = !casting.empty();
    return changed;
}

/// Changes of the integrator use the same path as functions, and change no light.
LightParts SceneLight::takeChanges() {
    if (!std::exchange(functionMayBeNew_, false))
        return 0;
    const Optics& optics = scene_.layer().optics;
    const bool sendsOther = ambientChannels(lighting_) > 1 && !sendTheSame(lit_.materials, optics.materials);
    if (takeTheSame(lit_, optics) && !sendsOther)
        return 0;
    lit_ = {};
    lit_.table = optics.table;
    lit_.scale = optics.scale, lit_.offset = optics.offset;
    lit_.gradientOpacity = optics.gradientOpacity;
    lit_.materials = optics.materials;
    light_->functionChanged(scene_.layer().table, optics);
    tissueNumber_ = PlanRevisions::next();
    takeMaps({}, Maps::none);
    next_.clear();
    return kAllLight;
}

/// Space behind an isosurface takes light, which distance maps do not include.
LightPath lightPathOf(const FramePlan& scene, const ShadowRays* rays) {
    const Layer& volume = scene.layer();
    const bool leaps = scene.view.quality.skipping && volume.optics.surfaces.empty();
    return {volume.cache.get(),
            &scene.info(),
            &volume.selection,
            volume.mixed() ? &volume.levels : nullptr,
            &volume.optics,
            leaps ? &volume.occupancy : nullptr,
            rays,
            volume.labelBricks.get(),
            scene.view.meshesShade ? std::span<const SceneMesh>(scene.view.meshes)
                                   : std::span<const SceneMesh>()};
}

ShadowQuality shadowQualityOf(const FramePlan& scene) {
    return qualityOf(scene.view.shadowQuality, scene.view.lighting);
}

/// The plan has charged them with its light.
void SceneLight::takeMeshes() {
    const auto& occlusion = scene_.view.lighting.occlusion;
    light_->setMeshes(nullptr, 0);
    meshBits_.reset(); // never two at once
    if (scene_.view.meshes.empty() || !occlusion || occlusion->method == OcclusionMethod::histogram)
        return;
    const MeshLattice lattice = meshLattice(scene_.info(), *occlusion, scene_.view.meshes);
    meshBits_ = std::make_unique<MeshBits>(scene_.view.meshes, lattice.grid, nullptr, threads_, false);
    light_->setMeshes(meshBits_.get(), lattice.level);
}

std::vector<PlacedLight> SceneLight::placedLights() const {
    std::vector<PlacedLight> placed;
    for (const Light& light : castingLights(lighting_.lights))
        placed.push_back(placedLight(light, scene_.view.camera));
    return placed;
}

void SceneLight::takeMaps(std::vector<ShadowMaps> maps, Maps kind) {
    light_->setShadows({});
    shadows_ = std::move(maps);
    light_->setShadows(shadows_);
    mapsNumber_ = PlanRevisions::next();
    maps_ = kind;
    viewIsNew_ = viewIsNew_ && kind == Maps::none;
    levelsAreNew_ = levelsAreNew_ && kind != Maps::whole;
}

bool SceneLight::makeMaps() {
    if (mapsAreWhole())
        return false;
    takeMaps({}, Maps::none); // never two at once
    const LightPath field = lightPathOf(scene_, rays_);
    std::vector<ShadowMaps> maps;
    for (const PlacedLight& light : placedLights()) {
        maps.emplace_back(light, field, shadowQualityOf(scene_));
        maps.back().build(field, threads_);
    }
    takeMaps(std::move(maps), Maps::whole);
    return true;
}

LightParts SceneLight::shadedBy(std::span<SceneLight* const> others) {
    std::vector<std::uint64_t> maps, tissues;
    std::vector<std::span<const ShadowMaps>> shadows;
    std::vector<Occluder::Other> tissue;
    for (const SceneLight* other : others) {
        maps.push_back(other->mapsNumber_);
        shadows.emplace_back(other->shadows_);
        tissues.push_back(other->tissueNumber_);
        tissue.push_back({&other->light_->tissue(), other->scene_.layer().cache.get()});
    }
    LightParts changed = 0;
    if (casts_ && maps != shadedBy_) {
        shadedBy_ = std::move(maps);
        light_->setOtherShadows(std::move(shadows));
        changed |= kShadowLight;
    }
    if (lighting_.occlusion && tissues != amidst_) {
        amidst_ = std::move(tissues);
        light_->setOtherTissue(std::move(tissue));
        changed |= kAmbientLight;
    }
    return changed;
}

bool SceneLight::makeMapsUntil(Deadline deadline) {
    if (mapsAreWhole())
        return false;
    const LightPath field = lightPathOf(scene_, rays_);
    if (next_.empty()) {
        takeMaps({}, Maps::none);
        nextBuilt_ = 0;
        for (const PlacedLight& light : placedLights())
            next_.emplace_back(light, field, shadowQualityOf(scene_));
    }
    while (nextBuilt_ < next_.size()) {
        if (!next_[nextBuilt_].buildUntil(field, threads_, deadline))
            return false;
        ++nextBuilt_;
    }
    takeMaps(std::move(next_), Maps::whole);
    next_.clear();
    return true;
}

bool SceneLight::makeCoarseMaps(bool viewCounts) {
    if (!casts_ || (maps_ != Maps::none && !(viewIsNew_ && viewCounts)))
        return false;
    next_.clear();
    takeMaps({}, Maps::none);
    const Selection bricks = atOneLevel(scene_.layer().selection, kCoarseLevel);
    LightPath field = lightPathOf(scene_, rays_);
    field.selection = &bricks;
    field.levels = nullptr;
    field.occupancy = nullptr; // it is for the drawn bricks
    field.rays = nullptr;
    ShadowQuality quality = shadowQualityOf(scene_);
    quality.mapSize = std::max(2, quality.mapSize / kCoarseMapPart);
    quality.stepVoxels *= 1 << kCoarseLevel;
    quality.lightMapPart *= kCoarseMapPart;
    std::vector<ShadowMaps> maps;
    for (const PlacedLight& light : placedLights()) {
        maps.emplace_back(light, field, quality);
        maps.back().build(field, threads_);
    }
    takeMaps(std::move(maps), Maps::coarse);
    return true;
}

VoxelLight& SceneLight::ready() {
    takeChanges();
    makeMaps();
    return *light_;
}

LightReport SceneLight::report(std::size_t planeBytes) const {
    LightReport report;
    report.channels = channels();
    report.planeBytes = planeBytes;
    report.seconds = seconds_;
    const auto& occlusion = scene_.view.lighting.occlusion;
    report.emission = occlusion && occlusion->emission > 0;
    std::size_t more = 0, rays = 0;
    for (const ShadowMaps& shadow : shadows_)
        for (const std::shared_ptr<ShadowMap>& map : shadow.maps()) {
            ++report.maps;
            report.mapSize = map->size();
            report.mapBytes += map->bytes();
        }
    for (const ShadowMaps& shadow : shadows_)
        for (const std::shared_ptr<LightMap>& map : shadow.lightMaps()) {
            ++report.lightMaps;
            report.lightMapSize = map->grid().size;
            report.lightMapBytes += map->bytes();
        }
    report.mapKind = lighting_.shadowMap.kind;
    for (const ShadowMaps& shadow : shadows_) {
        const std::size_t of = shadow.maps().size();
        more += static_cast<std::size_t>(shadow.shareOfMore() * 1e6) * of;
        rays += of;
        report.mapError = std::max(report.mapError, shadow.largestError());
    }
    report.shareOfMore = rays == 0 ? 0 : 1e-6 * static_cast<double>(more) / static_cast<double>(rays);
    return report;
}

StoredLight::StoredLight(SceneLight& light, const FramePlan& scene, MemoryBudget& ram)
    : map_(scene.layer().mixed() ? &scene.layer().levels : nullptr), selection_(&scene.layer().selection),
      level_(scene.layer().selection.finest()), channels_(light.channels()),
      extent_(levelExtent(scene.info().extentVoxels, level_)), bricks_(selection_->levels.size()) {
    const auto channels = static_cast<std::size_t>(channels_);
    VoxelLight& voxels = light.ready();
    std::vector<BrickToLight> wanted;
    std::size_t texels = bricks_.size();
    for (std::size_t b = 0; b < bricks_.size(); ++b)
        if (const int level = selection_->levels[b]; level + 1 < kLevelCount) {
            wanted.push_back({b, level, std::max(level, voxels.finestLevel())});
            texels += cellCount(glm::ivec3(kBrickExtent >> level));
        }
    charge_ = ram.charge(texels * channels * sizeof(std::uint16_t), "light of the bricks");
    BrickCache& cache = *scene.layer().cache;
    std::vector<std::uint8_t> levels = selection_->levels;
    for (std::uint8_t& level : levels)
        level = std::max(level, static_cast<std::uint8_t>(voxels.finestLevel()));
    voxels.light(wanted, levels, kAllLight, cache,
                 [&](const BrickToLight& b, int channel, const Chunk& chunk, int edge) {
                     const auto* from = reinterpret_cast<const std::uint16_t*>(chunk.bytes.get());
                     const std::size_t count = cellCount(glm::ivec3(edge));
                     std::vector<std::uint16_t>& to = bricks_[b.brick].texels;
                     to.resize(count * channels);
                     std::size_t n = count * static_cast<std::size_t>(channel);
                     for (int z = 0; z < edge; ++z)
                         for (int y = 0; y < edge; ++y)
                             for (int x = 0; x < edge; ++x)
                                 to[n++] = from[linearIndex({x, y, z}, glm::ivec3(kChunkExtent))];
                 });
    standing_.resize(bricks_.size() * channels);
    for (std::size_t b = 0; b < bricks_.size(); ++b)
        for (std::size_t part = 0; part < kLightParts && bricks_[b].texels.empty(); ++part)
            for (int n = 0; n < voxels.channelsOf(part); ++n)
                standing_[b * channels + static_cast<std::size_t>(voxels.firstChannelOf(part) + n)] =
                    voxels.standing(b, part, n, cache);
}

float StoredLight::Channel::at(int level, const glm::ivec3& i) const {
    const glm::ivec3 brick = i >> (5 - level);
    const std::size_t b = linearIndex(brick, light_.selection_->bricks);
    const std::vector<std::uint16_t>& texels = light_.bricks_[b].texels;
    if (texels.empty())
        return mean(brick);
    const int edge = kBrickExtent >> level;
    return texels[cellCount(glm::ivec3(edge)) * static_cast<std::size_t>(channel_) +
                  linearIndex(i & (edge - 1), glm::ivec3(edge))];
}

float StoredLight::Channel::mean(const glm::ivec3& brick) const {
    const std::size_t b = linearIndex(brick, light_.selection_->bricks);
    return light_
        .standing_[b * static_cast<std::size_t>(light_.channels_) + static_cast<std::size_t>(channel_)];
}

bool StoredLight::Channel::isEmpty(const glm::ivec3& brick) const {
    return light_.selection_->levels[linearIndex(brick, light_.selection_->bricks)] == Selection::kEmpty;
}

} // namespace tessera
