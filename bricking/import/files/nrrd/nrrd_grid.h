// bricking/import/files/nrrd/nrrd_grid.h: the layers of an NRRD file and their place in the patient.
// For volumes and labels.
#pragma once

#include "bricking/import/files/nrrd/nrrd_header.h"
#include "core/base/volume.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

struct NrrdGrid {
    enum class Order : std::uint8_t { single, interleaved, apart };
    VolumeInfo info;                // of every layer, in the file's order of axes; patient space is LPS
    int layers = 1;                 // at least 1
    Order order = Order::single;    // interleaved: a voxel's layers lie together; apart: a layer's voxels
    bool saysSpacing = true;        // of all axes, in a unit that is known
    std::vector<std::string> notes; // on what the file does not say, and how it is taken
};

/// Throws InputError naming `where` for a file of other than three axes of space and at most one of layers,
/// for layers along a middle axis, and for geometry that is no volume's.
/// @param spacingMm  of axes of which the file does not say it
NrrdGrid nrrdGridOf(const NrrdHeader& header, const std::string& where,
                    const std::optional<glm::dvec3>& spacingMm = {});

} // namespace tessera
