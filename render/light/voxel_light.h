// render/light/voxel_light.h: the light of bricks' samples (docs/sampling.md, "Light per voxel"): occlusion,
// and of each light that casts shadows the share that gets there. Computed chunk by chunk of a level; chunks
// of a coarser level serve finer bricks, interpolated, where light is asked for no finer.
#pragma once

#include "bricking/cache/brick_cache.h"
#include "core/lighting.h"
#include "render/light/occlusion.h"
#include "render/light/shadow_maps.h"

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace tessera {

/// Light as it is kept: leaf::kLightOne.
std::uint16_t lightTexel(float light);

/// A brick that samples are wanted of, at a level below the coarsest.
struct BrickToLight {
    std::size_t brick = 0;
    int level = 0;
};

class VoxelLight {
  public:
    /// Channels are lightChannels() of them: occlusion first, then every light that casts a shadow.
    /// @param shadows  of the lights that cast some, in order, built
    /// All must outlive it.
    VoxelLight(const VolumeInfo& info, const Statistics& statistics, const Lighting& lighting,
               std::span<const ShadowMaps> shadows, int threads);
    /// RAM that threads work in, and that chunks are kept in.
    static std::size_t bytes(const VolumeInfo& info, const Lighting& lighting, int threads);

    int channels() const { return channels_; }
    /// The transfer function, or a shadow, is another: all light is.
    void functionChanged(const TransferTable& table, const Optics& optics);

    /// Gets the samples of a brick, edge^3, x fastest, for one channel; one call at a time.
    using Put = std::function<void(const BrickToLight&, int channel, const Chunk& samples, int edge)>;
    /// Lights bricks, in any order.
    void light(std::vector<BrickToLight> bricks, BrickCache& cache, const Put& put);
    /// Of bricks that stand as one value: that of the coarsest level's sample.
    std::uint16_t standing(std::size_t brick, int channel, BrickCache& cache);

  private:
    struct LitChunk {
        std::vector<std::uint16_t> texels; // channel by channel, 32^3 each
        std::vector<std::uint8_t> bricks;  // that are lit
        bool isWhole = false;              // all of them are
        std::uint64_t used = 0;
    };
    using Ordered = std::pair<std::pair<int, std::uint64_t>, BrickToLight>; // by level and place
    using Chunks = std::map<ChunkKey, LitChunk>;
    void light(const ChunkKey& key, LitChunk& chunk, BrickCache& cache, OcclusionRoom& room) const;
    void lightChunks(std::span<const ChunkKey> keys, BrickCache& cache);
    void fillAndPut(const std::vector<Ordered>& ordered, std::size_t first, std::size_t end,
                    const Put& put) const;
    void forget(std::size_t most);
    void fill(const BrickToLight& brick, int channel, std::uint16_t* out) const;

    const VolumeInfo& info_;
    std::span<const ShadowMaps> shadows_;
    std::optional<Occlusion> occlusion_;
    int threads_, channels_;
    Occluder occluder_;
    int finest_; // level of light; finer bricks take it from there
    Chunks chunks_;
    std::uint64_t turn_ = 0;
};

} // namespace tessera
