// render/light/scatter_light.h: light that tissue around a place scatters to it (course notes 6.1.3;
// docs/sampling.md, "Scattered light"). It is gathered as the light of emissive tissue is, along rays. What
// tissue sends is its colour times the light that gets there, by the shadow maps.
#pragma once

#include "render/light/light_source.h"

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

namespace tessera {

class ScatterLight : public LightSource, private LightOfSamples {
  public:
    /// Rays that gather light: figure 6.11.
    static constexpr int kRays = 32;

    /// @param info, statistics  outlive this
    /// @param ambient  other ambient light, to which scattered light is added; null: all of it gets
    /// everywhere
    ScatterLight(const VolumeInfo& info, const Statistics& statistics, const Lighting& lighting,
                 std::unique_ptr<LightSource> ambient);
    /// RAM for the threads' working sets, and for extinctions of chunks.
    static std::size_t bytes(const VolumeInfo& info, const Lighting& lighting, int threads);

    int channels() const override { return 3; }
    int finestLevel() const override;
    bool readsTissue() const override { return ambient_ && ambient_->readsTissue(); }
    void setShadows(std::span<const ShadowMaps> shadows) override;
    void functionChanged(const TransferTable& table, const Optics& optics) override;
    /// Where lights cast shadows, their maps must be set.
    void fill(const ChunkKey& chunk, BrickCache& cache, OcclusionRoom& room,
              std::uint16_t* texels) const override;

  private:
    struct Source {
        Light light;
        int caster = -1; // its shadow maps; -1: it casts no shadow
    };
    void at(int level, const glm::ivec3& first, std::span<glm::vec3> out) const override;
    std::unique_ptr<OcclusionRoom> takeRoom() const;

    const VolumeInfo& info_;
    Occluder tissue_;
    std::unique_ptr<LightSource> ambient_;
    std::vector<Source> sources_; // those that are scattered
    std::span<const ShadowMaps> shadows_;
    mutable std::mutex mutex_;
    mutable std::vector<std::unique_ptr<OcclusionRoom>> rooms_; // not in use
};

} // namespace tessera
