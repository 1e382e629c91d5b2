// viewer/annotations/figure_part.h: the part of a figure that a picture is, from its scene and what was
// drawn.
#pragma once

#include "bricking/store/store_reader.h"
#include "core/base/budget.h"
#include "core/scene/scene.h"
#include "render/picture/render_scene.h"
#include "viewer/annotations/figure.h"

namespace tessera {

/// Its box is the picture's, from (0,0) on. Reads statistics and labels only where the annotations ask for
/// legends. Volumes have no names in it, for those of files may be patients'.
/// @param stores  of the scene's volumes, in order
FigurePart figurePart(const Scene& scene, Stores stores, const RenderResult& result, MemoryBudget& ram,
                      int threads);

/// "measured error: ...", or why there is none.
std::string errorCaption(const RenderResult& result);

} // namespace tessera
