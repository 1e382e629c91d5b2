// bricking/analysis/body/body_marks.h: sets of voxels by others: what lies beyond them on a side, around
// them, or is connected to them. Internal to this room.
#pragma once

#include "bricking/analysis/body/body_voxels.h"

#include <array>
#include <cstddef>
#include <glm/vec3.hpp>

namespace tessera {

/// A side of the patient: lines of a slice run outwards to it, along x or y.
struct Outwards {
    int axis = 1;
    bool up = true;
    Outwards opposite() const { return {axis, !up}; }
};
/// A side and the opposite one, two times.
constexpr std::array<Outwards, 4> kSides = {{{1, true}, {1, false}, {0, true}, {0, false}}};

/// Marks of the air that the borders of each slice reach: what is not firm.
Marks reached(const Marks& firm);
/// Marks of all marked samples and of what lies outwards of any on its line.
Marks onwards(const Marks& marks, const Outwards& side);
/// Marks of the whole lines that have a marked sample.
Marks linesOf(const Marks& marks, const Outwards& side);
/// Marks of what lies beyond all of the body on one side, of whole lines where there is no body.
Marks beyond(const Marks& body, const Outwards& side);
/// The number of lines that meet both the body and a marked sample.
std::size_t facingBody(const Marks& marks, const Marks& body, const Outwards& side);
/// Marks of every sample with a marked one among the eight around it in its slice, or itself.
Marks dilatedInSlices(const Marks& marks);
/// Marks of every sample with a marked one among the 26 around it, or itself.
Marks dilated(const Marks& marks);
/// Marks of every sample with a marked one beyond one of its faces, or itself.
Marks besideFaces(const Marks& marks);
/// Adds what is connected to the marked samples, by faces, through `open` alone, as far as mostMm: from the
/// nearest marked sample in steps, of several such ways the first in the order of samples.
void growInto(Marks& marks, const Marks& open, const BodyGrid& grid, double mostMm);
/// Memory that growInto() takes at most.
std::size_t growthBytes(const glm::ivec3& extent);

} // namespace tessera
