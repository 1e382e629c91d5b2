// render/backends/native/native_field.h: the field of the native engine's bricks, by the scalar text of
// render/contract. Packets leave blends of bricks, gradients across their faces, and surfaces to it.
#pragma once

#include "render/backends/native/host_plane.h"
#include "render/contract/sampler.h"

#include <memory>
#include <utility>
#include <vector>

namespace tessera {

/// Names the bricks that rays wait for; for several threads.
class WantedBricks {
  public:
    explicit WantedBricks(std::size_t bricks) : first_(bricks, UINT32_MAX) {}
    void name(std::size_t brick, std::uint32_t ray);
    /// Per brick the first ray that waits for it; forgets them.
    std::vector<std::uint32_t> take();

  private:
    std::vector<std::uint32_t> first_;
};

/// For one ray or packet at a time.
class NativeField {
  public:
    /// @param map  of mixed levels, or null
    /// @param level  else: of all bricks
    NativeField(const HostPlane& plane, const LevelMap* map, int level, Gradient kind)
        : plane_(plane), map_(map), level_(level), extent_(levelExtent(plane.info().extentVoxels, level)),
          kind_(kind) {}

    float value(const glm::vec3& p);
    /// Distance of samples at p, voxels: of the brick that it lies in.
    float pitch(const glm::vec3& p) const;
    glm::vec3 gradient(const glm::vec3& p) { return gradient(p, kind_); }
    glm::vec3 gradient(const glm::vec3& p, Gradient by);
    /// Shares of light that reach p; setLight() must have been called.
    leaf::ReceivedLight<float> received(const glm::vec3& p, const leaf::LightingNumbers& lighting);
    /// Labels' shares at p; setLabels() must have been called.
    leaf::LabelShares<float> labels(const glm::vec3& p);
    /// The gradient of their medium.
    glm::vec3 mediumGradient(const glm::vec3& p);
    void setLabels(const std::vector<std::unique_ptr<HostPlane>>& planes, const leaf::LabelNumbers& numbers);
    /// Fields of light, one a channel.
    void setLight(const std::vector<std::unique_ptr<HostPlane>>& planes);

    /// True if a brick was lacking since the last call.
    bool takeMissing() { return std::exchange(missing_, false); }
    bool lacks() { return takeMissing(); }
    /// From now on bricks that are read, lacking or not, are named for a ray; null: no longer.
    void name(WantedBricks* wanted, std::uint32_t ray) {
        wanted_ = wanted;
        ray_ = ray;
    }

    // As samples for the contract's functions.
    const glm::ivec3& extent() const { return extent_; }
    float at(const glm::ivec3& i) { return at(level_, i); }
    const LevelMap& map() const { return *map_; }
    float at(int level, const glm::ivec3& i);
    float mean(const glm::ivec3& brick) const { return brickAt(brick).mean; }
    bool isEmpty(const glm::ivec3& brick) const {
        return (brickAt(brick).low >> 24) == native::PacketBrick::kValue;
    }

  private:
    float labelAt(int channel, const glm::vec3& p);
    bool valueInBrick(const glm::vec3& p, float& value) const;
    const native::PacketBrick& brickAt(const glm::ivec3& brick) const {
        return plane_.bricks()[linearIndex(brick, plane_.grid())];
    }

    const HostPlane& plane_;
    const LevelMap* map_;
    int level_;
    glm::ivec3 extent_;
    Gradient kind_;
    std::vector<NativeField> light_, labels_;
    leaf::LabelNumbers numbers_; // of the labels
    bool missing_ = false;
    WantedBricks* wanted_ = nullptr;
    std::uint32_t ray_ = 0;
};

} // namespace tessera
