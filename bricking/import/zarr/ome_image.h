// bricking/import/zarr/ome_image.h: an image of OME-Zarr 0.4 or 0.5 (ngff.openmicroscopy.org): its arrays
// from the finest on, and where their voxels lie in the patient.
#pragma once

#include "bricking/import/zarr/zarr_array.h"
#include "bricking/import/zarr/zarr_node.h"
#include "core/base/json_reader.h"
#include "core/base/volume.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

/// OME's attributes of a group, or of an array of Zarr 3: all of Zarr 2's, those below "ome" of Zarr 3's.
/// Nullopt: none. The node must outlive it.
std::optional<JsonValue> omeAttributesOf(const ZarrNode& node);

struct OmeAxis {
    std::string name;
    bool isOfSpace = false;
    std::string unit, orientation;     // "millimeter"; RFC-4's "right-to-left"; "" none
    double scale = 1, translation = 0; // in the unit: centre of voxel i = scale * i + translation
};

/// One of an image's arrays, at its resolution.
struct OmeLevel {
    std::string path; // below the group
    std::vector<OmeAxis> axes;
    bool saysScale = false; // it has a transformation of that type
};

struct OmeImage {
    std::vector<OmeLevel> levels;      // smallest voxels first; at least one
    std::vector<std::string> channels; // names, where "omero" has them
    std::vector<std::string> notes;    // findings that a user should know, one a line
};

/// The first of a group's "multiscales"; nullopt: it has none. Throws InputError naming the file and the key
/// for what is missing or out of range, other versions, and transformations other than scale and translation.
std::optional<OmeImage> omeImageOf(const ZarrNode& group);

/// The three axes of space of an array, and all others.
struct OmeGrid {
    std::array<std::size_t, 3> axes{}; // of the array that become z, y, x: slowest first
    struct Other {
        std::size_t axis = 0;
        std::string name;
        std::int64_t length = 1; // above 1: the array holds several volumes
        double stepSeconds = 0;  // of an axis of time; 0: not said
    };
    std::vector<Other> others; // slowest first
    /// Extent and affine in the array's order; millimetres, axes x, y, z as left, posterior, superior unless
    /// the axes tell their orientations.
    VolumeInfo info;
    /// Why distances of voxels are not known, which are then 1 for the affine: "" they are.
    std::string spacingProblem;
    std::vector<std::string> notes;
};
/// @param level  of the image, whose array it is
/// Throws InputError naming `where` unless three axes are of space, for another number of axes than the
/// array's, and for implausible places.
OmeGrid omeGridOf(const OmeImage& image, const OmeLevel& level, const ZarrArray& array,
                  const std::string& where);

/// The same of an array without OME's attributes: its last three axes, 1 mm apart. Its place means nothing.
OmeGrid bareGridOf(const ZarrArray& array);

/// Throws InputError naming `where` if an array holds several volumes.
void requireOneVolume(const OmeGrid& grid, const std::string& where);

/// Names that lead below a folder, joined by '/'. Throws InputError naming `where` for other texts.
std::string pathBelow(const std::string& path, const std::string& where);

} // namespace tessera
