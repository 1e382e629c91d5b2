// render/light/light_plane.h: the plane with the light per voxel of a scene, beside the values. It has the
// same pages and slots, one sample of light for every sample. The engine supplies planes for the samples, one
// per channel. Their contents are computed here for every engine.
//
// A still has all light before its rays are cast. Interactive pictures use coarse light first: new bricks are
// lit by samples of 8^3 voxels. In idle time refine() refines the light, brick by brick, up to that of a
// still.
#pragma once

#include "render/light/scene_light.h"
#include "render/residency/plane.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace tessera {

class LightPlane : public Plane {
  public:
    /// @param channels  planes of 16-bit samples; all outlive this
    /// @param together  they take all channels of a brick or none
    LightPlane(SceneLight& light, const FramePlan& scene, std::vector<Plane*> channels,
               bool together = false);

    void put(const AtlasSlot& slot, const BrickSamples& samples, Work& work) override;
    void publish(std::span<const BrickEntry> entries) override;
    /// The first part of settle(), for volumes that shade one another: takes changes and makes shadow maps.
    void makeMaps();
    /// The second part: the maps of others fall on this one.
    void shadedBy(std::span<SceneLight* const> others);
    /// Lights new bricks, or all if the light has changed; before rays are cast.
    void settle(Work& work);

    /// From now on settle() computes coarse light first.
    void lightCoarselyFirst() { coarseFirst_ = true; }
    /// During motion: shadows of lights fixed to the camera are not updated.
    void setHaste(bool hasty) { hasty_ = hasty; }
    /// The plan's lighting has changed, with the same number of channels.
    void lightingChanged();
    /// Refines light until the deadline, at least a little; not while rays are cast.
    /// @param seen  visibility per brick, for priority; empty: all equal
    void refine(std::span<const float> seen, SceneLight::Deadline deadline, Work& work);
    /// True if all light of the current bricks is computed.
    bool isWhole() const;

  private:
    /// Values in place of the level of a brick's light: it has none; it has outdated light.
    static constexpr std::uint8_t kNone = 255, kOld = 254;
    using Levels = std::vector<std::uint8_t>;

    void lookAgain();
    bool isHere(std::size_t brick) const;
    int wholeLevel(std::size_t brick) const;
    LightParts lacking(std::size_t brick, int finest) const;
    bool lacksAnything(LightParts parts) const;
    void forget(LightParts parts, std::uint8_t as);
    void lightBricks(std::vector<BrickToLight> bricks, int finest, LightParts parts, Work& work);
    void sortQueue(std::span<const float> seen);
    void lightAll(int finest, LightParts considered, Work& work);
    LightParts quickParts() const;
    void lightStanding();
    void publishAll();
    bool refineTo(int finest, LightParts considered, LightParts parts, std::span<const float> seen,
                  SceneLight::Deadline deadline, Work& work);
    void refineAll(std::span<const float> seen, SceneLight::Deadline deadline, Work& work);

    SceneLight& light_;
    const FramePlan& scene_;
    std::vector<Plane*> channels_;
    bool together_;
    std::vector<BrickEntry> entries_;
    std::vector<std::optional<AtlasSlot>> slots_;                  // of every brick, as last put
    std::array<Levels, kLightParts> lit_;                          // level of its light since then
    std::array<std::vector<std::uint16_t>, kLightParts> standing_; // of every brick, by its channels
    LightParts standingIsOld_ = kAllLight;
    bool published_ = false; // some channels lack some
    bool coarseFirst_ = false, hasty_ = false;
    std::vector<BrickToLight> queue_; // queue of refineTo(), in reverse
    LightParts queueParts_ = 0;       // of its bricks
    int queueLevel_ = -1;             // target of refinement; -1: none
    Levels expected_;                 // of all bricks, when their light reaches a level; that level, or -1
    int expectedFinest_ = -1;
    int ambientDone_ = SceneLight::kCoarseLevel; // reached by the ambient light of all bricks
};

} // namespace tessera
