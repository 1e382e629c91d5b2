// bricking/import/files/plain_file_source.h: uncompressed voxels in one file, [z][y][x] with x fastest, for
// raw files and uncompressed NIfTI files.
#pragma once

#include "bricking/import/source/input_file.h"
#include "bricking/import/source/random_slab_source.h"
#include "bricking/import/source/voxel_types.h"

#include <cstdint>
#include <memory>
#include <string>

namespace tessera {

/// Position and type of the voxels.
struct VoxelLayout {
    FileType type = FileType::i16;
    bool bigEndian = false;
    std::uint64_t offsetBytes = 0;
};

/// Bytes that the voxels take in the file; info.validate() must have passed.
std::uint64_t voxelBytesInFile(const VolumeInfo& info, FileType type);

/// The caller has checked that the file is long enough; info.type is storedTypeOf(layout.type).
std::unique_ptr<SlabSource> makePlainFileSource(InputFile file, const VolumeInfo& info,
                                                const VoxelLayout& layout, std::string description);

} // namespace tessera
