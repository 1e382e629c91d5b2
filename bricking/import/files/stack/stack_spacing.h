// bricking/import/files/stack/stack_spacing.h: what a picture file says of the lattice of its stack: tags of
// resolution, the descriptions of ImageJ and of OME. Private to stacks.
#pragma once

#include "bricking/import/files/stack/ome_text.h"
#include "bricking/import/files/stack/picture_walk.h"

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>

namespace tessera {

struct StackLattice {
    std::optional<glm::dvec2> pixelMm; // x, y
    std::optional<double> sliceMm;     // between slices
    std::uint64_t images = 0;          // that the description counts; 0: it does not
    std::uint64_t others = 1;          // channels times points of time
    bool hasSpacing() const { return pixelMm && sliceMm; }
    /// "0.5 x 0.5 mm within slices, nothing of their distance".
    std::string said() const;
};

StackLattice latticeOf(const PictureHead& head);
/// Of one volume of an OME-TIFF.
StackLattice latticeOf(const OmeTiffImage& image);

} // namespace tessera
