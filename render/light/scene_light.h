// render/light/scene_light.h: the light of a scene's voxels, and the plane that holds it beside the values:
// in the same pages and slots, one sample of light for every sample. An engine brings planes of its own for
// the samples, one a channel; what is in them is computed here, whichever engine it is.
#pragma once

#include "render/light/voxel_light.h"
#include "render/plan/scene_plan.h"
#include "render/residency/plane.h"

#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace tessera {

/// What the light of a scene's voxels came to.
struct LightReport {
    int channels = 0;
    bool emission = false;                    // light that tissue sends is among them
    std::size_t planeBytes = 0, mapBytes = 0; // beside the bricks; maps of shadows
    std::size_t maps = 0;
    int mapSize = 0;        // rays along a side of one
    float mapError = 0;     // of the light that maps hold, at most
    double shareOfMore = 0; // of their rays that err by more than was asked
    double seconds = 0;     // that computing all of it took so far
};

class SceneLight {
  public:
    /// Of a plan whose lighting has channels of light; it outlives this and does
    /// not move.
    SceneLight(const ScenePlan& scene, int threads);

    int channels() const { return lightChannels(scene_.view.lighting); }
    /// The transfer function, the camera, or levels of bricks may be others.
    void functionChanged() { functionMayBeNew_ = true; }
    void viewChanged();
    void levelsChanged() { shadowsAreNew_ = true; }

    /// Whether light that was given is another now; asks for all of it again.
    bool takeChanges();
    /// The light as things are: builds maps of shadows where it must. Valid until something changes.
    VoxelLight& ready();
    const std::vector<ShadowMaps>& shadows() const { return shadows_; }
    /// Computing took so long.
    void took(double seconds) { seconds_ += seconds; }
    /// @param planeBytes  what engines keep of it
    LightReport report(std::size_t planeBytes) const;

  private:
    void lookAtFunction();

    const ScenePlan& scene_;
    int threads_;
    std::vector<ShadowMaps> shadows_;
    std::optional<VoxelLight> light_;
    std::vector<glm::vec4> litTable_; // by which light was computed
    double seconds_ = 0;              // that computing took
    bool shadowsAreNew_ = true, functionMayBeNew_ = true, functionIsNew_ = true, changed_ = true;
};

/// Light beside values, for a BrickResidency.
class LightPlane : public Plane {
  public:
    /// @param channels  planes of 16-bit samples; all outlive this
    LightPlane(SceneLight& light, const ScenePlan& scene, std::vector<Plane*> channels);

    void put(const AtlasSlot& slot, const BrickSamples& samples, Work& work) override;
    void publish(std::span<const BrickEntry> entries) override;
    /// Lights what was put, or all where light has changed; before rays are drawn.
    void settle(Work& work);

  private:
    SceneLight& light_;
    const ScenePlan& scene_;
    std::vector<Plane*> channels_;
    std::vector<BrickEntry> entries_;
    std::vector<std::optional<AtlasSlot>> slots_; // of every brick, as it was last put
    std::vector<std::uint8_t> isLit_;             // since then
    bool published_ = false;                      // entries that channels do not know
};

} // namespace tessera
