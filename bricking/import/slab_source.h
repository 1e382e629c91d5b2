// bricking/import/slab_source.h: what every importer gives: a volume's description, then its slices, forward
// only. One interface for files, series and phantoms, so that a volume never has to fit in memory.
#pragma once

#include "core/volume.h"

#include <cstddef>
#include <memory>
#include <span>
#include <string>

namespace tessera {

class SlabSource {
  public:
    virtual ~SlabSource() = default;
    /// Complete from the start, except for the counts nonFiniteVoxels and clampedVoxels, which grow as slices
    /// are read and are final after the last one.
    virtual const VolumeInfo& info() const = 0;
    /// Reads the next `count` slices (z ascending) into out: [z][y][x], x fastest, little-endian stored
    /// values. out.size() == count * extent.y * extent.x * bytesPerValue. Throws InputError naming the file
    /// on truncated or damaged data. Non-finite values arrive already replaced by fillStored.
    virtual void readSlices(int count, std::span<std::byte> out) = 0;
    /// One line for people: what is being read ("134 DICOM slices, series 2"). Never a patient identifier.
    virtual std::string describe() const = 0;
};

} // namespace tessera
