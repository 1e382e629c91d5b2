// render/light/scene_light.h: the inputs of a scene's voxel light as they stand: the function, and shadow
// maps of the bricks that are drawn. A still has all of them before anything is lit. Pictures that follow one
// another have coarse maps first, and full ones when there was time for them.
#pragma once

#include "render/light/voxel_light.h"
#include "render/plan/frame_plan.h"

#include <chrono>
#include <cstddef>
#include <memory>
#include <vector>

namespace tessera {

/// What the light of a scene's voxels came to.
struct LightReport {
    int channels = 0;
    bool emission = false;                    // light that tissue sends is among them
    std::size_t planeBytes = 0, mapBytes = 0; // beside the bricks; shadow maps
    std::size_t maps = 0;
    int mapSize = 0;        // rays along a side of one
    float mapError = 0;     // of the light that maps hold, at most
    double shareOfMore = 0; // of their rays that err by more than was asked
    double seconds = 0;     // that computing all of it took so far
};

class SceneLight {
  public:
    using Deadline = std::chrono::steady_clock::time_point;
    /// Samples of coarse light: one for 8^3 voxels.
    static constexpr int kCoarseLevel = 3;

    /// Of a plan whose lighting has channels of light; it outlives this and does
    /// not move.
    SceneLight(const FramePlan& scene, int threads);

    int channels() const { return lightChannels(scene_.view.lighting); }
    /// The transfer function, the camera, or levels of bricks may be others.
    void functionChanged() { functionMayBeNew_ = true; }
    void viewChanged();
    void levelsChanged();
    /// The plan's lighting is another, with as many channels. Returns the parts of light that are.
    LightParts lightingChanged();

    /// Takes the function and the lights as they are. Returns the parts of light that are others from now on.
    LightParts takeChanges();
    /// Builds shadow maps of the bricks as they are, where these do not hold. Returns true where shadows are
    /// others from now on.
    bool makeMaps();
    /// The same as far as time goes, for all that has changed; true when they are there and new.
    bool makeMapsUntil(Deadline deadline);
    /// Makes coarse maps, where there are none, and where the camera moved a light, if it counts.
    bool makeCoarseMaps(bool viewCounts);
    /// The camera has moved a light since maps were made.
    bool viewIsNew() const { return viewIsNew_; }
    /// Shadow maps are of the bricks, lights and function as they are.
    bool mapsAreWhole() const { return !casts_ || (maps_ == Maps::whole && !levelsAreNew_ && !viewIsNew_); }

    /// Its changes must have been taken, and shadows need maps.
    VoxelLight& voxels() { return *light_; }
    /// All of it, for all bricks at once.
    VoxelLight& ready();
    const std::vector<ShadowMaps>& shadows() const { return shadows_; }
    /// Computing took so long.
    void took(double seconds) { seconds_ += seconds; }
    /// @param planeBytes  what engines keep of it
    LightReport report(std::size_t planeBytes) const;

  private:
    enum class Maps { none, coarse, whole };
    LightPath fieldAsDrawn() const;
    std::vector<PlacedLight> placedLights() const;
    void takeMaps(std::vector<ShadowMaps> maps, Maps kind);

    const FramePlan& scene_;
    int threads_;
    Lighting lighting_;  // by which light is computed
    bool casts_ = false; // some light has shadows
    std::vector<ShadowMaps> shadows_;
    Maps maps_ = Maps::none;
    std::vector<ShadowMaps> next_; // in the works
    std::size_t nextBuilt_ = 0;    // of them are whole
    std::unique_ptr<VoxelLight> light_;
    std::vector<glm::vec4> litTable_; // by which light was computed
    std::vector<leaf::MaterialNumbers> litMaterials_;
    double seconds_ = 0; // that computing took
    bool functionMayBeNew_ = true, levelsAreNew_ = true, viewIsNew_ = true;
};

} // namespace tessera
