// bricking/import/labels/nrrd/nrrd_grid.h: the layers of an NRRD file and their place in the patient.
// Private to the NRRD reader.
#pragma once

#include "bricking/import/labels/nrrd/nrrd_header.h"
#include "core/base/volume.h"

#include <cstdint>
#include <string>
#include <vector>

namespace tessera {

struct NrrdGrid {
    enum class Order : std::uint8_t { single, interleaved, apart };
    VolumeInfo info;             // of every layer, in the file's order of axes; patient space is LPS
    int layers = 1;              // at least 1
    Order order = Order::single; // interleaved: a voxel's layers lie together; apart: a layer's voxels
    std::vector<std::string> notes;
};

/// Throws InputError naming `where` for a file of other than three axes of space and at most one of layers,
/// for layers along a middle axis, and for geometry that is no volume's.
NrrdGrid nrrdGridOf(const NrrdHeader& header, const std::string& where);

} // namespace tessera
