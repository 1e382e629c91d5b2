// tests/support/sample_plane.h: a plane of bricks' samples that a test can look at.
#pragma once

#include "render/residency/plane.h"

#include <gtest/gtest.h>
#include <map>
#include <utility>
#include <vector>

namespace tessera::test {

/// Samples in slots, as an atlas has them: by their place in it.
class SamplePlane : public Plane {
  public:
    void put(const AtlasSlot& slot, const BrickSamples& samples, Work& work) override {
        const glm::ivec3 to = slot.originTexels();
        EXPECT_EQ(samples.edge, kBrickExtent >> slot.level);
        for (int n = 0; n < samples.edge * samples.edge * samples.edge; ++n) {
            const glm::ivec3 at = gridPosition(static_cast<std::size_t>(n), glm::ivec3(samples.edge));
            const std::size_t in = linearIndex(samples.first + at, glm::ivec3(kChunkExtent));
            held_[key(to + at)] =
                static_cast<float>(storedValue(ValueType::f32, samples.chunk.bytes.get() + 4 * in));
        }
        work.bytesUploaded += 1;
        isBusy = true;
        put_.push_back(samples.brick);
    }
    void finish() override { isBusy = false; }
    void publish(std::span<const BrickEntry> given) override { entries.assign(given.begin(), given.end()); }
    float at(const glm::ivec3& texel) const { return held_.at(key(texel)); }
    /// Bricks that were put since the last call, in order.
    std::vector<std::size_t> putSince() { return std::exchange(put_, {}); }

    std::vector<BrickEntry> entries;
    bool isBusy = false;

  private:
    static std::size_t key(const glm::ivec3& texel) { return linearIndex(texel, glm::ivec3(1024)); }
    std::map<std::size_t, float> held_;
    std::vector<std::size_t> put_;
};

} // namespace tessera::test
