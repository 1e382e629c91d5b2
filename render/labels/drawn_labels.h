// render/labels/drawn_labels.h: the labels of a picture as factors of its samples (docs/sampling.md,
// "Labels"): for planes beside the values, for light, and for the statistics that culling reads.
#pragma once

#include "bricking/cache/chunk_source.h"
#include "bricking/labels/label_volume.h"
#include "bricking/statistics/statistics.h"
#include "core/base/brick.h"
#include "core/base/budget.h"
#include "core/scene/labels.h"
#include "render/contract/scene_numbers.h"

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <vector>

namespace tessera {

/// The factors of a set of labels, in [0,1]; all 0 where it is hidden.
struct LabelFactors {
    float plain = 1, tinted = 0, solid = 0;
    glm::vec3 colour{0}; // linear light, not premultiplied
    bool operator==(const LabelFactors&) const = default;
    bool shows() const { return plain > 0 || tinted > 0 || solid > 0; }
};

/// Texels of a channel in the layout of a brick at level 0.
constexpr std::size_t kBrickTexels = std::size_t{kBrickExtent} * kBrickExtent * kBrickExtent;

class DrawnLabels {
  public:
    /// @param volume   on the lattice of the volume that is drawn
    /// @param table    its labels, with the names and colours that they have in the picture
    /// @param bySet    of every set of the table
    /// @param density  extinction per mm of the labels' medium
    /// @param borders  between samples: blended factors, or each sample's own
    DrawnLabels(std::unique_ptr<LabelVolume> volume, LabelTable table, std::vector<LabelFactors> bySet,
                float density, LabelBorders borders = LabelBorders::smooth);

    const LabelVolume& volume() const { return *volume_; }
    const LabelTable& table() const { return table_; }
    std::span<const LabelFactors> factors() const { return bySet_; }
    /// Which channels there are.
    const leaf::LabelNumbers& numbers() const { return numbers_; }
    /// Labels of the table that some voxel has, and that are drawn.
    std::size_t shownLabels() const;
    /// Something of the labels' medium is drawn.
    bool showsMedium() const { return numbers_.solid >= 0; }
    /// Other factors for the same sets; channels are found anew.
    void setFactors(std::vector<LabelFactors> bySet, float density);

    /// The texels of a brick at a level below the coarsest: channel by channel, each 32^3, of which the
    /// brick's (32 >> level)^3 samples are the first along each axis. Thread-safe.
    /// @param out  numbers().count * 32^3
    /// Throws InputError naming what cannot be read.
    void fill(std::size_t brick, int level, std::span<std::uint16_t> out) const;
    /// Of a brick that is drawn as one value: the mean over it.
    std::uint16_t standing(std::size_t brick, int channel) const;

    /// The shares of the function and of the medium at the samples of a chunk of any level, [z][y][x] of
    /// 32^3 each: extinction is function * tau + medium. Thread-safe.
    void extinctions(const ChunkKey& key, std::span<float> function, std::span<float> medium) const;

    /// Sets what shows of the cells and bricks of the volume that is drawn. Throws InputError where ram has
    /// no room.
    void showOnly(Statistics& statistics, MemoryBudget& ram);

  private:
    struct Sum;
    struct Texels;
    Sum sumOf(const glm::ivec3& lowCell, const glm::ivec3& highCell) const;
    bool hasBorder(const glm::ivec3& cell) const;
    Statistics::LabelledBrick labelledBrick(const glm::ivec3& first, const glm::ivec3& end) const;
    int onlySetOf(const glm::ivec3& brick) const;
    void put(const Sum& sum, int level, std::uint16_t* at) const;
    void fillFromVoxels(const glm::ivec3& brick, int level, std::span<std::uint16_t> out) const;

    std::unique_ptr<LabelVolume> volume_;
    LabelTable table_;
    glm::ivec3 extent_{0}, cells_{0}, bricks_{0};
    double voxelMm_; // the edge of a cube with a voxel's volume
    LabelBorders borders_;
    std::vector<LabelFactors> bySet_;
    leaf::LabelNumbers numbers_;
    std::vector<std::uint16_t> texelsBySet_, standing_; // numbers_.count a set; a brick
    Charge showsCharge_;
};

} // namespace tessera
