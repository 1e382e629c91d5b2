// render/light/scene_light.h: the current inputs of a scene's light per voxel: the function, and shadow maps
// of the drawn bricks. A still has all of them before lighting. Interactive pictures have coarse maps first,
// and full ones later.
#pragma once

#include "render/contract/leaves.h"
#include "render/contract/sampler.h"
#include "render/light/voxel_light.h"
#include "render/plan/frame_plan.h"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace tessera {

/// Statistics of a scene's light per voxel.
struct LightReport {
    int channels = 0;
    bool emission = false;                    // emitted light is among them
    std::size_t planeBytes = 0, mapBytes = 0; // beside the bricks; shadow maps
    std::size_t maps = 0;
    ShadowMapKind mapKind = ShadowMapKind::deep;
    int mapSize = 0; // rays along a side of one
    std::size_t lightMaps = 0, lightMapBytes = 0;
    int lightMapSize = 0;   // likewise
    float mapError = 0;     // largest error of light in deep maps; else 0
    double shareOfMore = 0; // share of rays with a larger error than requested
    double seconds = 0;     // total computing time so far
};

/// What light goes through on its way to a plan's bricks as they are drawn.
/// @param rays  of shadow maps; null: by the cache's samples
LightPath lightPathOf(const FramePlan& scene, const ShadowRays* rays);

/// How a plan's shadow maps are made.
ShadowQuality shadowQualityOf(const FramePlan& scene);

class SceneLight {
  public:
    using Deadline = std::chrono::steady_clock::time_point;
    /// Samples of coarse light: one for 8^3 voxels.
    static constexpr int kCoarseLevel = 3;

    /// For a plan whose lighting has channels of light; it outlives this and does not move.
    SceneLight(const FramePlan& scene, int threads);

    int channels() const { return lightChannels(scene_.view.lighting); }
    /// The transfer function, the camera, or levels of bricks may have changed.
    void functionChanged() { functionMayBeNew_ = true; }
    void viewChanged();
    void levelsChanged();
    /// The plan's lighting has changed, with the same number of channels. Returns the changed parts of light.
    /// Of several volumes, shadedBy() of all must follow.
    LightParts lightingChanged();

    /// Rays of full maps until the next call; null: by the cache's samples.
    void castBy(const ShadowRays* rays) { rays_ = rays; }

    /// Updates the function and the lights. Returns the changed parts of light.
    LightParts takeChanges();
    /// Builds outdated shadow maps for the current bricks. Returns true if shadows have changed.
    bool makeMaps();
    /// The same until the deadline; true if maps are complete and have changed.
    bool makeMapsUntil(Deadline deadline);
    /// Makes coarse maps if there are none, or if the camera moved a light and this matters.
    bool makeCoarseMaps(bool viewCounts);
    /// Shadows of other volumes fall on this one too, and their tissue takes its ambient light. Changes of
    /// all must have been taken and their maps be whole; they stay until the next call. Returns the changed
    /// parts of light.
    LightParts shadedBy(std::span<SceneLight* const> others);
    /// True if the camera has moved a light since maps were made.
    bool viewIsNew() const { return viewIsNew_; }
    /// True if shadow maps match bricks, lights and function.
    bool mapsAreWhole() const { return !casts_ || (maps_ == Maps::whole && !levelsAreNew_ && !viewIsNew_); }

    /// Changes must have been taken, and shadows need maps.
    VoxelLight& voxels() { return *light_; }
    /// Computes all light, for all bricks at once.
    VoxelLight& ready();
    const std::vector<ShadowMaps>& shadows() const { return shadows_; }
    /// Adds computing time.
    void took(double seconds) { seconds_ += seconds; }
    /// @param planeBytes  memory in engines
    LightReport report(std::size_t planeBytes) const;

  private:
    enum class Maps { none, coarse, whole };
    std::vector<PlacedLight> placedLights() const;
    void takeMaps(std::vector<ShadowMaps> maps, Maps kind);
    void takeMeshes();

    const FramePlan& scene_;
    int threads_;
    const ShadowRays* rays_ = nullptr;
    Lighting lighting_;  // by which light is computed
    bool casts_ = false; // some light has shadows
    std::vector<ShadowMaps> shadows_;
    /// Of these among all maps that were made; of the tissue, likewise.
    std::uint64_t mapsNumber_ = 0, tissueNumber_ = 0;
    std::vector<std::uint64_t> shadedBy_, amidst_; // those of other volumes
    Maps maps_ = Maps::none;
    std::vector<ShadowMaps> next_;       // maps in progress
    std::size_t nextBuilt_ = 0;          // of them complete
    std::unique_ptr<MeshBits> meshBits_; // that occlude the volume; none: there are none
    std::unique_ptr<VoxelLight> light_;
    Optics lit_;         // by which light was computed, as far as it matters; without a table: none was
    double seconds_ = 0; // that computing took
    bool functionMayBeNew_ = true, levelsAreNew_ = true, viewIsNew_ = true;
};

// The light of all bricks of a selection in RAM, as samples for the contract's functions
// (render/contract/sampler.h). The mirror reads it.

class StoredLight {
  public:
    StoredLight() = default;
    /// Computes the light of all bricks.
    /// @param ram  budget for its memory
    StoredLight(SceneLight& light, const FramePlan& scene, MemoryBudget& ram);

    /// The samples of one channel; of mixed levels if there is a level map.
    class Channel {
      public:
        Channel(const StoredLight& light, int channel) : light_(light), channel_(channel) {}
        const LevelMap& map() const { return *light_.map_; }
        const glm::ivec3& extent() const { return light_.extent_; }
        float at(const glm::ivec3& i) const { return at(light_.level_, i); }
        float at(int level, const glm::ivec3& i) const;
        float mean(const glm::ivec3& brick) const;
        bool isEmpty(const glm::ivec3& brick) const;

      private:
        const StoredLight& light_;
        int channel_;
    };

    /// Shares of light that reach a point.
    template <typename Real>
    leaf::ReceivedLight<Real> at(const glm::vec<3, Real>& p, const leaf::LightingNumbers& lighting) const {
        return leaf::receivedLight<Real>(lighting, [&](int channel) {
            Channel samples(*this, channel);
            const Real texel = map_ ? interblockValue(samples, p)
                                    : fieldValue(samples, p, Real(1) / static_cast<Real>(1 << level_));
            return texel * Real(1 / leaf::kLightOne);
        });
    }

  private:
    struct Brick {
        std::vector<std::uint16_t> texels; // channel by channel, edge^3 each
    };
    const LevelMap* map_ = nullptr;
    const Selection* selection_ = nullptr;
    int level_ = 0, channels_ = 0; // without mixed levels: of all bricks
    glm::ivec3 extent_{0};
    std::vector<Brick> bricks_;
    std::vector<std::uint16_t> standing_; // of bricks without samples, channel by channel
    Charge charge_;
};

} // namespace tessera
