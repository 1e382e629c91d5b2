// render/backends/native/host_plane.h: bricks' samples in host memory, as packets of rays read them. Bricks
// of level 0 can have a ghost layer (`Apron` in code) of their neighbours' samples: one layer before them and
// two behind. No cell that begins in a brick needs another one then, nor does a central difference over a
// whole pitch around it. Where there is no neighbour the ghost layer repeats the volume's outermost samples.
// Beside an empty brick it holds that brick's value.
#pragma once

#include "core/base/budget.h"
#include "render/backends/native/packet.h"
#include "render/contract/level_map.h"
#include "render/residency/pages.h"
#include "render/residency/plane.h"

#include <cstddef>
#include <memory>
#include <vector>

namespace tessera {

/// Layers of a brick's ghost layer, before and behind it.
constexpr int kGhostBefore = 1, kGhostBehind = 2;
constexpr int kGhostedEdge = kGhostBefore + kBrickExtent + kGhostBehind;

class HostPlane : public Plane {
  public:
    /// Samples before the first brick and behind the last that may be read, of no value. Of 4^3 samples
    /// around one in a brick most lie in the next slices; loads of several reach further.
    static constexpr std::size_t kAround = 2 * (kGhostedEdge + 1) * kGhostedEdge + 32;

    /// @param limits  of the engine: how many samples a page has
    /// @param memory  budget that samples and bricks' entries are charged to
    HostPlane(const VolumeInfo& info, std::size_t pages, const TextureLimits& limits, int threads,
              MemoryBudget& memory);
    /// The same places for samples of another type.
    HostPlane(const VolumeInfo& info, ValueType type, const char* what, std::size_t pages,
              const TextureLimits& limits, int threads, MemoryBudget& memory);

    void put(const AtlasSlot& slot, const BrickSamples& samples, Work& work) override;
    /// By several threads.
    void putAll(std::span<const BrickInSlot> bricks, Work& work) override;
    bool takesManyAtOnce() const override { return true; }
    void publish(std::span<const BrickEntry> entries) override;
    /// Levels are others.
    void levelsChanged() { settled_ = false; }
    /// Brings ghost layers and boxes up to date with all that was put and published, for these levels; before
    /// rays are drawn.
    /// @param map  of mixed levels, or null
    /// @param level  else: of all bricks
    void settle(const LevelMap* map, int level);

    std::size_t bytes() const { return charge_.bytes(); }
    const std::vector<native::PacketBrick>& bricks() const { return bricks_; }
    const void* samples() const { return samples_; }
    const void* samplesOf(const native::PacketBrick& brick) const; // its first, which is there
    native::SampleKind kind() const { return kind_; }
    std::int32_t rowPitch(int level) const { return level == 0 ? edge_ : kBrickExtent >> level; }
    std::int32_t slicePitch(int level) const { return rowPitch(level) * rowPitch(level); }
    const VolumeInfo& info() const { return info_; }
    const glm::ivec3& grid() const { return grid_; }

    /// PacketBrick::low of bricks that need no other one: of level 0, their ghost layers filled.
    static constexpr std::uint32_t kLowWithGhost = 0x070707;

    /// Sample i of a level's lattice from the brick that holds it, which is there.
    float sampleAt(const native::PacketBrick& brick, int level, const glm::ivec3& i) const;

  private:
    struct Free {
        void operator()(std::byte* bytes) const;
    };
    bool fillGhostLayer(std::size_t brick);
    void setBox(std::size_t brick, const LevelMap* map, int level);
    template <typename Sample> bool fillGhostLayerOf(const glm::ivec3& brick);
    template <typename Sample> Sample* at(std::uint32_t sample) {
        return reinterpret_cast<Sample*>(samples_) + sample;
    }

    const VolumeInfo& info_;
    ValueType type_;
    native::SampleKind kind_;
    glm::ivec3 grid_{0}, box_{0}; // bricks; pages
    int edge_ = kBrickExtent;     // of a brick of level 0 with its ghost layer
    int threads_;
    Charge charge_;
    std::unique_ptr<std::byte[], Free> room_;
    std::byte* samples_ = nullptr; // in it
    std::vector<std::uint8_t> levelOfPage_;
    std::vector<std::uint8_t> putInPage_;      // since ghost layers were filled: pages whose samples are new
    std::vector<BrickEntry> entries_, filled_; // as published; as they were when ghost layers were filled
    std::vector<native::PacketBrick> bricks_;
    std::vector<std::uint8_t> hasGhostLayer_;
    bool settled_ = false;
};

} // namespace tessera
