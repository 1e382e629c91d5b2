// render/light/scatter_light.h: light that tissue scatters, on top of other ambient light (AddedLight), and
// where it comes from the tissue around a place (course notes 6.1.3; docs/sampling.md, "Scattered light"). It
// is gathered as the light of emissive tissue is, along rays. What tissue sends is its colour times the light
// that gets there, by the shadow maps.
#pragma once

#include "render/light/light_source.h"

#include <cstddef>
#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

namespace tessera {

/// Ambient light in three channels: that of another source, if there is one, and light that is added to it.
class AddedLight : public LightSource {
  public:
    /// @param info  outlives this
    /// @param ambient  other ambient light; null: all of it gets everywhere
    AddedLight(const VolumeInfo& info, const Lighting& lighting, std::unique_ptr<LightSource> ambient);

    int channels() const override { return 3; }
    int finestLevel() const override { return ambient_ ? ambient_->finestLevel() : 0; }
    bool readsTissue() const override { return ambient_ && ambient_->readsTissue(); }
    void setShadows(std::span<const ShadowMaps> shadows) override { shadows_ = shadows; }
    void functionChanged(const TransferTable& table, const Optics& optics) override;
    /// Where lights cast shadows, their maps must be set.
    void fill(const ChunkKey& chunk, BrickCache& cache, OcclusionRoom& room,
              std::uint16_t* texels) const override;

  protected:
    struct Source {
        Light light;
        int caster = -1; // its shadow maps; -1: it casts no shadow
    };
    /// Takes the light to add to a texel.
    using Add = std::function<void(std::size_t texel, const glm::vec3& light)>;
    /// Finds the light that is added to texels of the room's runs.
    virtual void add(const ChunkKey& chunk, BrickCache& cache, const OcclusionRoom& room,
                     const Add& put) const = 0;

    const VolumeInfo& info() const { return info_; }
    /// The lights that tissue scatters.
    const std::vector<Source>& sources() const { return sources_; }
    /// Null: it casts no shadow.
    const ShadowMaps* mapsOf(const Source& source) const;
    /// Its light, times its factor; what its distance from a place divides that by.
    static glm::vec3 sentBy(const Source& source);
    float attenuation(const Source& source, const glm::dvec3& place) const;

  private:
    const VolumeInfo& info_;
    std::unique_ptr<LightSource> ambient_;
    std::vector<Source> sources_;
    std::span<const ShadowMaps> shadows_;
};

class ScatterLight : public AddedLight, private LightOfSamples {
  public:
    /// Rays that gather light: figure 6.11.
    static constexpr int kRays = 32;

    /// @param info, statistics  outlive this
    /// @param ambient  as AddedLight has it
    ScatterLight(const VolumeInfo& info, const Statistics& statistics, const Lighting& lighting,
                 std::unique_ptr<LightSource> ambient);
    /// RAM for the threads' working sets, and for extinctions of chunks.
    static std::size_t bytes(const VolumeInfo& info, const Lighting& lighting, int threads);

    int finestLevel() const override;
    void functionChanged(const TransferTable& table, const Optics& optics) override;

  private:
    void add(const ChunkKey& chunk, BrickCache& cache, const OcclusionRoom& room,
             const Add& put) const override;
    void at(int level, const glm::ivec3& first, std::span<glm::vec3> out) const override;
    std::unique_ptr<OcclusionRoom> takeRoom() const;

    Occluder tissue_;
    mutable std::mutex mutex_;
    mutable std::vector<std::unique_ptr<OcclusionRoom>> rooms_; // not in use
};

} // namespace tessera
