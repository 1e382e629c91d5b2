// render/light/histogram_light.h: occlusion, and colours of the surroundings, by local histograms
// (docs/sampling.md, "Occlusion by histograms"). After an edit of the transfer function a table of some
// thousand rows is all that is computed; a texel of light is looked up in it.
#pragma once

#include "bricking/statistics/local_histograms.h"
#include "render/light/light_source.h"

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace tessera {

class HistogramLight : public LightSource {
  public:
    /// @param histograms  of the occlusion's radius; outlive this
    HistogramLight(const VolumeInfo& info, const LocalHistograms& histograms, const Occlusion& occlusion);
    int channels() const override { return bleeds_ ? 3 : 1; }
    int finestLevel() const override { return histograms_.level; }
    bool isQuick() const override { return true; }
    void functionChanged(const TransferTable& table, const Optics& optics) override;
    void fill(const ChunkKey& chunk, BrickCache& cache, OcclusionRoom& room,
              std::uint16_t* texels) const override;

    /// A representative's light without bias and gamma: the share that is left, and the surroundings' colour
    /// by its factor.
    struct Row {
        float open = 1;
        glm::vec3 colour{0};
    };
    const std::vector<Row>& rows() const { return rows_; }
    /// What tissue of one extinction everywhere takes from the light of a place, [0,1): the mean over a way
    /// of the radius's length, as local occlusion has it.
    static double takenBy(double extinctionPerMm, double radiusMm);

  private:
    Row at(const glm::ivec3& sample, int level) const;
    std::uint16_t texel(const Row& row, int channel) const;

    const LocalHistograms& histograms_;
    Occlusion occlusion_;
    bool bleeds_;
    std::vector<Row> rows_;                            // of the representatives
    std::array<std::vector<std::uint16_t>, 3> texels_; // of these, by channel
};

} // namespace tessera
