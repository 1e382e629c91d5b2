// render/plan/framing.h: fits a camera: what is shown of a volume fills its picture.
#pragma once

#include "bricking/statistics/statistics.h"
#include "bricking/store/store_reader.h"
#include "core/base/budget.h"
#include "core/scene/camera.h"
#include "core/scene/scene.h" // FittedView
#include "core/scene/transfer_function.h"
#include "render/plan/drawn_part.h"

#include <cstddef>

namespace tessera {

/// Opacity of what must be inside the picture; a little below 0.02, from which a pixel can be
/// told from nothing.
constexpr double kLeastOpacityFramed = 0.015;

/// The camera of a view: fitted to the volume's box, or to what table shows, of all or of part; to the box
/// where it shows nothing. Statistics say which cells could be outermost, and rays through their voxels which
/// are. So cells that show next to nothing, or nothing though their range says that they might, move no
/// camera. Only the voxels near the picture's edges are read. The same whatever the threads, the engine and
/// the budgets. Throws InputError where ram cannot hold framingBytes().
Camera fittedCamera(const FittedView& view, const StoreReader& store, const Statistics& statistics,
                    const TransferTable& table, const DrawnPart& part, const glm::ivec2& imageSize,
                    MemoryBudget& ram, int threads);

/// A camera that holds as much whatever the turn about the patient's axis through its focal point, from the
/// view's side at first: of a turntable. Some 12 times the work. Throws as fittedCamera() does.
Camera turningCamera(const FittedView& view, const StoreReader& store, const Statistics& statistics,
                     const TransferTable& table, const DrawnPart& part, const glm::ivec2& imageSize,
                     MemoryBudget& ram, int threads);

/// Memory that fitting to what is shown takes at least, while it lasts.
/// @param threads  0: all processors
std::size_t framingBytes(const VolumeInfo& info, int threads);

} // namespace tessera
