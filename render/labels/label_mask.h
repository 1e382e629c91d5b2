// render/labels/label_mask.h: labels that a scene hides, as a mask (docs/sampling.md, "Masks"): for rays that
// keep one value, such as a maximum without bones.
#pragma once

#include "bricking/mask/mask.h"
#include "render/labels/drawn_labels.h"

#include <memory>
#include <vector>

namespace tessera {

class LabelMask : public HiddenPart {
  public:
    /// @param labels  whose sets are drawn wholly or not at all
    explicit LabelMask(std::unique_ptr<DrawnLabels> labels);

    Part of(const glm::ivec3& low, const glm::ivec3& high) const override;
    /// The share of a sample's voxels that have hidden labels alone.
    void read(int level, const glm::ivec3& first, const glm::ivec3& count,
              std::span<float> out) const override;

    const DrawnLabels& labels() const { return *labels_; }

  private:
    std::unique_ptr<DrawnLabels> labels_;
    std::vector<Part> ofCell_; // of all cells
};

/// Of every set whether it is drawn at all.
std::vector<LabelFactors> drawnOrHidden(std::vector<LabelFactors> bySet);

} // namespace tessera
