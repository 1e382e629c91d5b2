// render/plan/framing.h: fits a camera to the visible part of a volume.
#pragma once

#include "bricking/statistics/statistics.h"
#include "bricking/store/store_reader.h"
#include "core/base/budget.h"
#include "core/scene/camera.h"
#include "core/scene/scene.h" // FittedView
#include "core/scene/transfer_function.h"
#include "render/labels/label_field.h"
#include "render/plan/drawn_part.h"

#include <cstddef>
#include <span>
#include <vector>

namespace tessera {

/// Least opacity of what must be inside the picture; a little below 0.02, from which a pixel is visible.
constexpr double kLeastOpacityFramed = 0.015;

/// The camera of a view: fitted to the volume's box, or to what table shows of all or of part; to the box if
/// nothing is visible. Statistics give the cells that could be outermost, and rays through their voxels
/// decide. So nearly invisible cells, and cells that are only possibly visible by their range, do not move
/// the camera. Only voxels near the picture's edges are read. Independent of threads, engine and budgets.
/// @param labels  of the volume, or null
/// @param meshes  that are drawn, and count as visible. Throws InputError if ram cannot hold framingBytes().
Camera fittedCamera(const FittedView& view, const ChunkSource& volume, const Statistics& statistics,
                    const TransferTable& table, const DrawnPart& part, const glm::ivec2& imageSize,
                    MemoryBudget& ram, int threads, LabelBricks* labels = nullptr,
                    std::span<const SceneMesh> meshes = {});

/// The same as a fit, which others may join; empty if nothing is visible.
ViewFit shownFit(const FittedView& view, const ChunkSource& volume, const Statistics& statistics,
                 const TransferTable& table, const DrawnPart& part, const glm::ivec2& imageSize,
                 MemoryBudget& ram, int threads, LabelBricks* labels = nullptr,
                 std::span<const SceneMesh> meshes = {});

// The camera of a turntable: fitted for every turn about the patient's axis through its focal point, starting
// from the view's side. Some 12 times the work.

/// What a volume shows from directions over half a turn, in parallel; empty where nothing is visible. Throws
/// as fittedCamera() does.
std::vector<ViewFit> turningFits(const FittedView& view, const ChunkSource& volume,
                                 const Statistics& statistics, const TransferTable& table,
                                 const DrawnPart& part, const glm::ivec2& imageSize, MemoryBudget& ram,
                                 int threads, LabelBricks* labels = nullptr,
                                 std::span<const SceneMesh> meshes = {});
/// The camera that holds them.
/// @param fits   of all volumes together
/// @param boxes  of these, which count where nothing is visible
Camera turningCamera(const FittedView& view, std::vector<ViewFit> fits,
                     std::span<const VolumeInfo* const> boxes, const glm::ivec2& imageSize);

/// Minimum memory for fitting to what is shown.
/// @param threads  0: all processors
std::size_t framingBytes(const VolumeInfo& info, int threads);

} // namespace tessera
