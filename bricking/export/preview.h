// bricking/export/preview.h: a store's preview: a small store of its own in its folder kPreviewFolder
// (store_reader.h), of a coarser level or the whole, whose values are rounded by the discrete cosine
// transform. It is drawn first where bytes come slowly.
#pragma once

#include "bricking/store/codec.h"
#include "core/base/budget.h"
#include "core/base/progress.h"
#include "core/base/volume.h"

#include <filesystem>
#include <string>

namespace tessera {

/// Most voxels of a preview: those of a picture's depth and width at a voxel a pixel.
constexpr std::size_t kPreviewVoxels = std::size_t{1} << 26;

/// Why a volume has no preview: its values are no whole numbers of one or two bytes. Empty: it may have one.
std::string whyNoPreview(const VolumeInfo& info);
/// The level that previews show: the finest that has at most kPreviewVoxels.
int previewLevel(const VolumeInfo& info);

/// Makes the preview of a finished store, in place of one that is there.
/// @param codec  of the discrete cosine transform
/// @param threads  0: all processors
/// @return  its bytes. Throws as importToStore() does, and InputError for whyNoPreview().
std::uint64_t writePreview(const std::filesystem::path& store, Codec codec, MemoryBudget& ram, int threads,
                           Progress* progress = nullptr);

} // namespace tessera
