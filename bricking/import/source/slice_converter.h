// bricking/import/source/slice_converter.h: converts slices of a file's numbers to slices of stored values. A
// voxel without a number (NaN: a mask, a field of view) gets the lowest value of the data. A 0 would be water
// in a CT: an opaque slab around the masked region.
#pragma once

#include "bricking/import/source/label_tally.h"
#include "bricking/import/source/voxel_types.h"
#include "core/base/volume.h"

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace tessera {

class SliceConverter {
  public:
    /// Calls its argument with all voxels of the file, in portions, from the first one.
    using VisitVoxels = std::function<void(const std::function<void(std::span<const std::byte>)>&)>;

    /// visitAll is called once, and only if there is a voxel without a number.
    SliceConverter(FileType type, bool bigEndian, VisitVoxels visitAll);
    /// Converts as storeVoxels() does and updates info: nonFiniteVoxels, absentStored, clampedVoxels, and
    /// after the last voxel a remark on labels. Throws what visitAll throws.
    void convert(std::span<const std::byte> in, std::span<std::byte> out, VolumeInfo& info);
    /// A loss that info does not count: whole numbers that float32 cannot hold.
    std::vector<std::string> notes() const;

  private:
    void findLowest(VolumeInfo& info) const;

    FileType type_;
    bool bigEndian_;
    VisitVoxels visitAll_;
    std::uint64_t rounded_ = 0, converted_ = 0;
    LabelTally labels_;
};

} // namespace tessera
