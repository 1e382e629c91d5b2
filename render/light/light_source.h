// render/light/light_source.h: what fills channels of light per voxel (docs/sampling.md, "Light per voxel"),
// chunk by chunk of a level. VoxelLight asks sources, and engines read planes: neither knows what is behind.
#pragma once

#include "bricking/cache/brick_cache.h"
#include "core/scene/lighting.h"
#include "render/light/occlusion.h"
#include "render/light/shadow_maps.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tessera {

/// Texels of one channel of a chunk, x fastest.
constexpr std::size_t kChunkTexels = std::size_t{kChunkExtent} * kChunkExtent * kChunkExtent;

/// The stored value of light: leaf::kLightOne of full light.
std::uint16_t lightTexel(float light);

class LightSource {
  public:
    LightSource() = default;
    virtual ~LightSource() = default;
    LightSource(const LightSource&) = delete;
    LightSource& operator=(const LightSource&) = delete;

    /// Channels that it fills, at least one.
    virtual int channels() const = 0;
    /// Finest level that it fills.
    virtual int finestLevel() const { return 0; }
    /// True if it fills texels so fast that no picture need have coarse light first.
    virtual bool isQuick() const { return false; }
    /// True if it needs the tissue around a chunk, which Occluder::find() reads into the room then.
    virtual bool readsTissue() const { return false; }
    /// Shadow maps of the lights that cast shadows, in order; they outlive this, or the next call. Sources
    /// that follow from none ignore them.
    virtual void setShadows(std::span<const ShadowMaps>) {}
    /// The transfer function has changed; both outlive this, or the next call.
    virtual void functionChanged(const TransferTable&, const Optics&) {}
    /// Fills the texels of a room's runs; others stay.
    /// @param chunk   of finestLevel() or a coarser level
    /// @param cache   of the volume's samples
    /// @param room    as Occluder::find() left it for the chunk; room for working
    /// @param texels  channel by channel, kChunkTexels each
    virtual void fill(const ChunkKey& chunk, BrickCache& cache, OcclusionRoom& room,
                      std::uint16_t* texels) const = 0;
};

/// Occlusion along rays, and light that tissue sends.
class OcclusionLight : public LightSource {
  public:
    /// @param occluder  of the same occlusion; outlives this
    OcclusionLight(const Occluder& occluder, const Occlusion& occlusion)
        : occluder_(occluder), occlusion_(occlusion) {}
    int channels() const override { return occluder_.gathersEmission() ? 3 : 1; }
    int finestLevel() const override { return occluder_.finestLevel(); }
    bool readsTissue() const override { return true; }
    void fill(const ChunkKey& chunk, BrickCache& cache, OcclusionRoom& room,
              std::uint16_t* texels) const override;

  private:
    const Occluder& occluder_;
    Occlusion occlusion_;
};

/// Shares of lights that cast shadows.
class ShadowLight : public LightSource {
  public:
    /// All outlive this.
    ShadowLight(const VolumeInfo& info, const native::PacketTarget& target, int channels)
        : info_(info), target_(target), channels_(channels) {}
    void setShadows(std::span<const ShadowMaps> shadows) override;
    /// As VoxelLight has them.
    void setOtherShadows(std::vector<std::span<const ShadowMaps>> others);
    bool hasMaps() const { return !shadows_.empty(); }

    int channels() const override { return channels_; }
    void fill(const ChunkKey& chunk, BrickCache& cache, OcclusionRoom& room,
              std::uint16_t* texels) const override;

  private:
    const VolumeInfo& info_;
    const native::PacketTarget& target_;
    int channels_;
    std::span<const ShadowMaps> shadows_;
    std::vector<std::span<const ShadowMaps>> otherShadows_;
};

} // namespace tessera
