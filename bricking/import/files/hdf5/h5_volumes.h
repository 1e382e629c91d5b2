// bricking/import/files/hdf5/h5_volumes.h: the volumes of an HDF5 file, and what it says of their lattices:
// Imaris, ITK, and sets with Fiji's "element_size_um". Private to the reader.
#pragma once

#include "bricking/import/files/hdf5/h5_bytes.h"
#include "bricking/import/files/hdf5/h5_slices.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

struct H5Volume {
    std::string name;                  // for people
    std::uint64_t at = 0, groupAt = 0; // headers of its set, and of the group that it is in
    bool isOfItk = false;
    H5VolumePlace place;
    std::string timePoint = {}, channel = {}; // of Imaris: names of its groups
    std::string time = {};                    // "time 2", of several
};

struct H5Volumes {
    bool areOfImaris = false;
    std::vector<H5Volume> all;
    std::string others;         // sets that are no volumes, and why; some of them
    std::size_t leadingOut = 0; // links to other files
};

/// By reading headers alone. Throws InputError naming the file for damage, groups more than 32 deep, more
/// than 10^6 objects or 10^4 volumes.
H5Volumes findH5Volumes(const H5File& file);

/// A volume of Imaris at all of its levels, finest first; another volume alone. Throws InputError naming the
/// file for damage.
std::vector<H5Volume> levelsOf(const H5File& file, const H5Volumes& volumes, const H5Volume& volume);

struct H5Lattice {
    glm::dvec3 firstMm{0};
    std::array<glm::dvec3, 3> stepMm{}; // along x, y, z
    bool isOfPatient = false;           // axes are LPS
    const char* field = "";
};
/// Nullopt: the file does not say it.
std::optional<H5Lattice> latticeOf(const H5File& file, const H5Volumes& volumes, const H5Volume& volume);

} // namespace tessera
