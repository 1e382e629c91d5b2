// render/light/voxel_light.h: the light of bricks' samples (docs/sampling.md, "Light per voxel"): occlusion,
// and the share of each shadow-casting light. It is computed chunk by chunk of a level. With a coarser
// resolution of light, chunks of a coarser level serve finer bricks, interpolated.
#pragma once

#include "bricking/cache/brick_cache.h"
#include "bricking/statistics/local_histograms.h"
#include "core/scene/lighting.h"
#include "render/light/light_source.h"
#include "render/light/occlusion.h"
#include "render/light/shadow_maps.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace tessera {

/// Parts of light with different inputs: ambient light depends on the function, shadows also on shadow maps.
/// Each has one source.
using LightParts = unsigned;
constexpr LightParts kAmbientLight = 1, kShadowLight = 2, kAllLight = kAmbientLight | kShadowLight;
constexpr std::size_t kLightParts = 2;

/// A brick to light, at a level below the coarsest.
struct BrickToLight {
    std::size_t brick = 0;
    int level = 0;
    /// Level at which light is computed, and from which it is interpolated: the brick's own or a coarser one,
    /// at least VoxelLight::finestLevel().
    int lightLevel = 0;
};

class VoxelLight {
  public:
    /// Channels are lightChannels() of them: occlusion first, then every light that casts a shadow.
    /// All must outlive it.
    /// @param histograms  where occlusion is by them; else null
    VoxelLight(const VolumeInfo& info, const Statistics& statistics, const Lighting& lighting, int threads,
               const LocalHistograms* histograms = nullptr);
    /// RAM for the threads' working sets, and for chunks.
    /// @param amongOthers  of a picture with several volumes
    /// @param meshes  take its light
    static std::size_t bytes(const VolumeInfo& info, const Lighting& lighting, int threads, bool amongOthers,
                             bool meshes);

    /// Channels of a part, and the first of them.
    int channelsOf(std::size_t part) const { return sources_[part] ? sources_[part]->channels() : 0; }
    int firstChannelOf(std::size_t part) const { return part == 0 ? 0 : channelsOf(0); }
    /// Finest level at which light of any part is computed.
    int finestLevel() const { return *std::min_element(finest_.begin(), finest_.end()); }
    /// Parts whose light follows from shadow maps.
    LightParts partsByMaps() const { return ambientByMaps_ ? kAllLight : kShadowLight; }
    /// Parts whose light is computed so fast that it need not be coarse at first.
    LightParts quickParts() const;
    /// Labels, or null; they outlive this. functionChanged() must follow.
    void setLabels(const DrawnLabels* labels) { occluder_.setLabels(labels); }
    /// The transfer function has changed, and so has all light.
    void functionChanged(const TransferTable& table, const Optics& optics);
    /// @param shadows  of the shadow-casting lights, in order, complete; they outlive this, or the next call
    void setShadows(std::span<const ShadowMaps> shadows);
    /// Shadows of other volumes, of the same lights: likewise.
    void setOtherShadows(std::vector<std::span<const ShadowMaps>> others);
    /// Other volumes, whose tissue takes ambient light here.
    void setOtherTissue(std::vector<Occluder::Other> others);
    /// Meshes that take ambient light here: Occluder::setMeshes().
    void setMeshes(const MeshBits* bits, int level);
    const Occluder& tissue() const { return occluder_; }

    /// Receives the samples of a brick, edge^3, x fastest, for one channel.
    using Put = std::function<void(const BrickToLight&, int channel, const Chunk& samples, int edge)>;
    /// Computes parts of the light of bricks, in any order. Shadows need maps.
    /// @param expected  for every brick the level of its light in upcoming calls: computed together with
    /// neighbours
    /// @param manyAtOnce  put() is called by several threads, in any order; else one call at a time
    void light(std::vector<BrickToLight> bricks, std::span<const std::uint8_t> expected, LightParts parts,
               BrickCache& cache, const Put& put, bool manyAtOnce = false);
    /// Light of bricks drawn as one value: that of the coarsest level's sample, for the n-th channel of a
    /// part.
    std::uint16_t standing(std::size_t brick, std::size_t part, int n, BrickCache& cache);

    /// Order of chunks in light(): bricks of one chunk, of any level, are adjacent.
    static std::pair<int, std::uint64_t> placeInOrder(const BrickToLight& brick, const glm::ivec3& grid);

  private:
    enum class State : std::uint8_t { dark, wanted, lit }; // of a brick of a chunk
    struct LitPart;
    void want(const ChunkKey& key, LitPart& lit, const glm::ivec3& lowest, const glm::ivec3& highest,
              std::span<const std::uint8_t> expected) const;
    struct LitPart {
        std::vector<std::uint16_t> texels; // channel by channel, 32^3 each; none: all 1
        std::vector<State> bricks;
        bool isWhole = false;  // all bricks are lit
        bool isWanted = false; // some are requested
    };
    struct LitChunk {
        std::array<LitPart, kLightParts> parts;
        std::uint64_t used = 0;
    };
    using Ordered = std::pair<std::pair<int, std::uint64_t>, BrickToLight>; // by level and place
    using Chunks = std::map<ChunkKey, LitChunk>;
    void light(const ChunkKey& key, LitChunk& chunk, BrickCache& cache, OcclusionRoom& room) const;
    void lightChunks(std::span<const ChunkKey> keys, BrickCache& cache);
    void lightAlike(std::vector<BrickToLight> bricks, std::span<const std::uint8_t> expected,
                    LightParts parts, BrickCache& cache, const Put& put, bool manyAtOnce);
    void fillAndPut(const std::vector<Ordered>& ordered, std::size_t first, std::size_t end, LightParts parts,
                    const Put& put, bool manyAtOnce) const;
    void forget(std::size_t most);
    void forgetPart(std::size_t part);
    void fill(const BrickToLight& brick, std::size_t part, int n, std::uint16_t* out) const;

    const VolumeInfo& info_;
    int threads_;
    Occluder occluder_; // finds what shows
    std::unique_ptr<LightSource> ambient_;
    bool ambientByMaps_ = false; // ambient light follows from shadow maps too
    ShadowLight shadows_;
    std::array<LightSource*, kLightParts> sources_{}; // of the parts; null: it has no channels
    std::array<int, kLightParts> finest_; // level of a part's light; finer bricks interpolate from it
    Chunks chunks_;
    std::uint64_t turn_ = 0;
};

} // namespace tessera
