// render/labels/label_plane.h: the plane with the labels' factors of bricks, beside the values. It has the
// same pages and slots. The engine supplies planes for the samples, one a channel.
#pragma once

#include "render/labels/drawn_labels.h"
#include "render/residency/plane.h"

#include <vector>

namespace tessera {

class LabelPlane : public Plane {
  public:
    /// @param channels  planes of 16-bit samples, as many as labels.numbers().count; all outlive this
    LabelPlane(const DrawnLabels& labels, std::vector<Plane*> channels);

    void put(const AtlasSlot& slot, const BrickSamples& samples, Work& work) override;
    bool takesManyAtOnce() const override;
    void finish() override;
    void publish(std::span<const BrickEntry> entries) override;

  private:
    const DrawnLabels& labels_;
    std::vector<Plane*> channels_;
};

} // namespace tessera
