// bricking/import/source/file_levels.h: the choice among the levels of a file that has its volume at several
// resolutions (SlabSource::fileLevels()).
#pragma once

#include "core/base/volume.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace tessera {

/// Bytes of a volume's voxels, decoded.
inline std::uint64_t decodedBytes(const VolumeInfo& info) {
    return info.voxelCount() * bytesPerValue(info.type);
}

/// The finest level of at most so many bytes, decoded; the coarsest where none is as small.
/// @param levels  finest first, at least one
inline int levelWithin(const std::vector<VolumeInfo>& levels, std::uint64_t bytes) {
    std::size_t level = 0;
    while (level + 1 < levels.size() && decodedBytes(levels[level]) > bytes)
        ++level;
    return static_cast<int>(level);
}

} // namespace tessera
