// viewer/annotations/figure_part.h: the part of a figure that a picture is, from its scene and what was
// drawn.
#pragma once

#include "bricking/store/store_reader.h"
#include "core/base/budget.h"
#include "core/base/volume.h"
#include "core/scene/colour_legend.h"
#include "core/scene/scene.h"
#include "render/picture/render_scene.h"
#include "viewer/annotations/figure.h"
#include "viewer/session/label_list.h"

#include <string>
#include <vector>

namespace tessera {

/// What the parts of one scene's pictures share: read once, where legends ask for it.
class FigureMaker {
  public:
    /// Reads statistics and labels. Throws InputError as loadStatistics() does, and for labels that cannot be
    /// read.
    /// @param stores  of the scene's volumes, in order; outlive this
    FigureMaker(const Scene& scene, Stores stores, MemoryBudget& ram, int threads);

    /// Its box is the picture's, from (0,0) on; the scene's where the result has no picture. Volumes have no
    /// names in it, for those of files may be patients'.
    /// @param scene  with the same volumes
    FigurePart part(const Scene& scene, const RenderResult& result) const;
    /// Of a picture that is not drawn yet, for its strips: with all labels, and words that are as long as
    /// those of its error are.
    /// @param scene  whose camera is placed, or is taken as it is by default
    FigurePart partToCome(const Scene& scene) const;

  private:
    std::vector<LegendVolume> volumes_; // none where no legend is asked for
    std::vector<LabelList> labels_;     // likewise, of every volume
    VolumeInfo info_;                   // of the first volume
    std::vector<std::string> values_;   // of measurements, where they are asked for
    bool orientationKnown_ = true;
};

/// "measured error: ...", or why there is none.
std::string errorCaption(const RenderResult& result);

} // namespace tessera
