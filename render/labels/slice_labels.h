// render/labels/slice_labels.h: labels over the values of a slice: fills and outlines (docs/sampling.md,
// "Labels in slices"). It knows no engine.
#pragma once

#include "bricking/cache/brick_cache.h"
#include "bricking/labels/label_table.h"
#include "bricking/store/store_reader.h"
#include "core/base/budget.h"
#include "core/scene/labels.h"
#include "render/labels/label_looks.h"
#include "render/labels/plane_places.h"

#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace tessera {

/// What labels make of a pixel.
struct LabelsOver {
    glm::vec3 keep{1}, add{0};
    float cover = 0; // of what is added, [0,1]
    /// @param colour  linear, premultiplied
    glm::vec4 operator()(const glm::vec4& colour) const {
        return {keep * glm::vec3(colour) + colour.a * add, colour.a};
    }
    /// Over that share of a colour. Labels are not less for it.
    glm::vec4 operator()(const glm::vec4& colour, float share) const {
        return {share * keep * glm::vec3(colour) + colour.a * add, colour.a * (cover + (1 - cover) * share)};
    }
};

/// For one thread at a time.
class SliceLabels {
  public:
    /// Opens imported labels, with a small cache in ram, which outlives this.
    /// @param scan   of the volume that they lie on
    /// @param where  of the labels, for messages
    /// Throws InputError naming the file that is missing or damaged, labels on other voxels than the scan's,
    /// patterns that no label matches, or a budget that is too small.
    SliceLabels(const Labels& labels, const VolumeInfo& scan, MemoryBudget& ram, int threads,
                const std::string& where);
    /// Other looks of the same labels. Throws InputError as above, and changes nothing then.
    void setLooks(const Labels& labels, const std::string& where);

    const LabelTable& table() const { return table_; }
    const Labels& labels() const { return labels_; }
    /// Labels that some set has, and that show.
    std::size_t shownLabels() const;
    /// Of the voxels that such pixels show: the finest of which their places meet every one.
    static int levelOf(const SurfacePlaces& places);

    struct Drawn {
        std::vector<std::uint32_t> values = {}; // of labels that have a place on the picture, ascending
        int level = 0;
    };
    /// Lays the labels over a picture.
    /// @param pixels        linear, premultiplied; [y][x] of places.size
    /// @param outlineScale  times the width of outlines
    /// @param shares        by which pixels are multiplied before; null: 1
    /// Throws InputError naming what cannot be read; some pixels may have their labels then.
    Drawn layOver(std::span<glm::vec4> pixels, const SurfacePlaces& places, double outlineScale = 1,
                  const std::vector<float>* shares = nullptr);
    /// The same of one pixel.
    LabelsOver overPixel(const glm::ivec2& pixel, const SurfacePlaces& places);

  private:
    struct Tile;
    void draw(Tile& tile);

    std::unique_ptr<StoreReader> voxels_;
    LabelTable own_, table_; // as it is in the store; with the names of the scene
    Labels labels_;
    SliceLooks looks_;
    int threads_;
    Charge charge_;
    std::unique_ptr<BrickCache> cache_; // last: its threads read the voxels
};

} // namespace tessera
