// render/labels/set_reader.h: the set of labels that a place of a slice has (docs/sampling.md, "Labels in
// slices").
#pragma once

#include "core/scene/labels.h"
#include "render/contract/lattice.h"

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

namespace tessera {

/// For one thread.
class SetReader {
  public:
    /// All outlive it.
    /// @param cache   of a volume of labels: numbers of sets
    /// @param shown   of every set its number without what does not show; 0: none
    SetReader(BrickCache& cache, const VolumeInfo& info, int level, LabelBorders borders,
              std::span<const std::uint16_t> shown);
    /// @param place  level-0 voxels; anywhere
    /// Throws InputError naming what cannot be read.
    std::uint16_t at(const glm::dvec3& place);

  private:
    using Place = glm::vec<3, std::int64_t>;
    void read(const glm::ivec3& first);
    std::uint16_t shownAt(double stored) const;

    LatticeReader samples_;
    int level_;
    bool nearest_;
    glm::dvec3 extent_;
    std::span<const std::uint16_t> shown_;
    glm::ivec3 first_{INT32_MIN}; // of the samples last read
    std::array<std::uint16_t, 8> sets_{};
    bool isOne_ = false; // they have one set
};

} // namespace tessera
