// render/light/light_plane.h: the plane that holds the light of a scene's voxels beside the values. It has
// the same pages and slots, one sample of light for every sample. An engine brings planes of its own for the
// samples, one a channel. Their contents are computed here, whichever engine it is.
//
// A still has all light before its rays are drawn. Pictures that follow one another ask for coarse light
// first: new bricks are lit by samples of 8^3 voxels. When nothing else is to be done, refine() makes the
// light finer, brick by brick, until it is what a still would have.
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
    /// Lights what was put, or all where light has changed; before rays are drawn.
    void settle(Work& work);

    /// From now on what settle() lights is coarse first.
    void lightCoarselyFirst() { coarseFirst_ = true; }
    /// Something moves: shadows of lights that the camera carries stay where they fell.
    void setHaste(bool hasty) { hasty_ = hasty; }
    /// The plan's lighting is another, with as many channels.
    void lightingChanged();
    /// Makes light finer as far as time goes, at least a little; not while rays are drawn.
    /// @param seen  per brick what is seen of it: more first; empty: all alike
    void refine(std::span<const float> seen, SceneLight::Deadline deadline, Work& work);
    /// All of it is there for the bricks as they are.
    bool isWhole() const;

  private:
    /// In place of the level that a brick's light was computed at: it has none; it has what was right before.
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
    void lightAll(int finest, Work& work);
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
    std::vector<std::optional<AtlasSlot>> slots_;                  // of every brick, as it was last put
    std::array<Levels, kLightParts> lit_;                          // since then, at which level
    std::array<std::vector<std::uint16_t>, kLightParts> standing_; // of every brick, by its channels
    LightParts standingIsOld_ = kAllLight;
    bool published_ = false; // channels do not know all
    bool coarseFirst_ = false, hasty_ = false;
    std::vector<BrickToLight> queue_; // what refineTo() does next, backwards
    LightParts queueParts_ = 0;       // of its bricks
    int queueLevel_ = -1;             // that it comes to; -1: there is none
    Levels expected_;                 // of all bricks, where light comes to a level; that one, or -1
    int expectedFinest_ = -1;
    int ambientDone_ = SceneLight::kCoarseLevel; // that all bricks' ambient light has come to
};

} // namespace tessera
