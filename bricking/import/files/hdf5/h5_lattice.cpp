// bricking/import/files/hdf5/h5_lattice.cpp: latticeOf() of h5_volumes.h. Rules: the Imaris 5.5 file format;
// HDF5ImageIO of ITK 5; the HDF5 plugin of Fiji.
#include "bricking/import/files/hdf5/h5_volumes.h"

#include "bricking/import/files/hdf5/h5_attributes.h"
#include "bricking/import/files/hdf5/h5_group.h"
#include "bricking/import/files/header_words.h"
#include "bricking/import/source/length_units.h"

#include <algorithm>
#include <cmath>

namespace tessera {
namespace {

/// Of an image's box, up to the faces of its outer voxels.
std::optional<H5Lattice> latticeOfImaris(const H5File& file, const H5Volume& volume) {
    const auto image = objectBelow(file, readH5Object(file, file.rootAt()), {"DataSetInfo", "Image"});
    if (!image)
        return std::nullopt;
    const double mm = millimetresOf(std::string(withoutBlanks(textAttribute(*image, "Unit").value_or(""))));
    H5Lattice lattice;
    lattice.field = "ExtMin and ExtMax of Imaris";
    for (int axis = 0; axis < 3; ++axis) {
        const auto end = [&](const char* name) {
            const auto said = textAttribute(*image, name + std::to_string(axis));
            return said ? realNumberOf(withoutBlanks(*said)).value_or(std::nan("")) : std::nan("");
        };
        const double low = end("ExtMin"), high = end("ExtMax");
        const double step =
            mm * (high - low) / static_cast<double>(volume.place.extents[static_cast<std::size_t>(2 - axis)]);
        if (!isLength(step))
            return std::nullopt;
        lattice.stepMm[static_cast<std::size_t>(axis)][axis] = step;
        lattice.firstMm[axis] = mm * low + step / 2;
    }
    return lattice;
}

/// "Spacing", "Origin" and "Directions" beside ITK's voxels, along x, y, z; a row of directions for each
/// axis.
std::optional<H5Lattice> latticeOfItk(const H5File& file, const H5Volume& volume) {
    const H5Object group = readH5Object(file, volume.groupAt);
    const auto numbersIn = [&](const char* name) {
        const auto set = objectBelow(file, group, {name});
        return set ? smallNumbersOf(*set).value_or(std::vector<double>{}) : std::vector<double>{};
    };
    const std::vector<double> spacing = numbersIn("Spacing"), origin = numbersIn("Origin"),
                              directions = numbersIn("Directions");
    const std::size_t axes = spacing.size();
    if (axes < 3 || origin.size() != axes || directions.size() != axes * axes)
        return std::nullopt;
    if (axes != volume.place.at.size())
        file.refuse("one number a voxel of ITK's image of " + std::to_string(axes) + " axes",
                    "several (a set of " + std::to_string(volume.place.at.size()) + " axes)");
    H5Lattice lattice;
    lattice.isOfPatient = true;
    lattice.field = "Spacing, Origin and Directions of ITK";
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (std::size_t part = 0; part < 3; ++part) {
            const auto at = static_cast<glm::length_t>(part);
            lattice.stepMm[axis][at] = spacing[axis] * directions[axis * axes + part];
            lattice.firstMm[at] = origin[part];
        }
    return lattice;
}

} // namespace

std::optional<H5Lattice> latticeOf(const H5File& file, const H5Volumes& volumes, const H5Volume& volume) {
    if (volumes.areOfImaris)
        return latticeOfImaris(file, volume);
    if (volume.isOfItk)
        if (const auto lattice = latticeOfItk(file, volume))
            return lattice;
    const auto sizes = numbersAttribute(readH5Object(file, volume.at), "element_size_um");
    const std::size_t axes = volume.place.at.size();
    if (!sizes || (sizes->size() != 3 && sizes->size() != axes))
        return std::nullopt;
    H5Lattice lattice;
    lattice.field = "element_size_um";
    constexpr double kMicrometre = 1e-3;
    const std::size_t first = sizes->size() == 3 ? 0 : volume.place.slowest;
    for (std::size_t n = 0; n < 3; ++n) { // z, y, x
        const double step = kMicrometre * (*sizes)[first + n];
        if (!isLength(step))
            return std::nullopt;
        lattice.stepMm[2 - n][static_cast<glm::length_t>(2 - n)] = step;
    }
    return lattice;
}

} // namespace tessera
