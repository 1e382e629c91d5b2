// bricking/import/source/random_slab_source.h: a SlabSource whose slices can be read in any order. A reversed
// slice axis is then free. Files that can only be read forward (gzip) are not of this kind.
#pragma once

#include "bricking/import/source/slab_source.h"
#include "core/base/error.h"

namespace tessera {

class RandomSlabSource : public SlabSource {
  public:
    /// Reads slice z, 0 <= z < extent.z, into out: [y][x]. Each slice must be read once, or counts repeat.
    virtual void readSliceAt(int z, std::span<std::byte> out) = 0;

    void readSlices(int count, std::span<std::byte> out) final {
        TESSERA_CHECK(count >= 0 && next_ + count <= info().extentVoxels.z);
        const std::size_t sliceBytes = count == 0 ? 0 : out.size() / static_cast<std::size_t>(count);
        for (int i = 0; i < count; ++i)
            readSliceAt(next_++, out.subspan(static_cast<std::size_t>(i) * sliceBytes, sliceBytes));
    }

  private:
    int next_ = 0;
};

/// Bytes of one slice of stored values.
inline std::size_t sliceBytesOf(const VolumeInfo& info) {
    return static_cast<std::size_t>(info.extentVoxels.x) * static_cast<std::size_t>(info.extentVoxels.y) *
           bytesPerValue(info.type);
}

} // namespace tessera
