// bricking/import/source/slab_source.h: SlabSource, the interface of every importer: a volume's description,
// then its slices, forward only. Files, series and phantoms share it, so a volume never has to fit in memory.
#pragma once

#include "core/base/volume.h"

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace tessera {

class SlabSource {
  public:
    virtual ~SlabSource() = default;
    /// Complete from the start, except for values from voxels, which are final after the last slice:
    /// nonFiniteVoxels, absentStored, clampedVoxels, lossy, remarks.
    virtual const VolumeInfo& info() const = 0;
    /// Reads the next `count` slices (z ascending) into out: [z][y][x], x fastest, little-endian stored
    /// values. out.size() == count * extent.y * extent.x * bytesPerValue. Throws InputError naming the file
    /// on truncated or damaged data. Non-finite values arrive already replaced by absentStored.
    virtual void readSlices(int count, std::span<std::byte> out) = 0;
    /// One line for people: "134 DICOM slices, series 2". Never a patient identifier.
    virtual std::string describe() const = 0;
    /// Findings of reading that a user should know, one per line; complete after the last slice.
    virtual std::vector<std::string> notes() const { return {}; }
};

} // namespace tessera
