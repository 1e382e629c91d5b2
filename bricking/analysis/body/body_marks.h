// bricking/analysis/body/body_marks.h: sets of voxels by others: what lies beyond them on a side, around
// them, or is connected to them. Internal to this room.
#pragma once

#include "bricking/analysis/body/body_voxels.h"

#include <array>
#include <cstddef>
#include <glm/vec3.hpp>

namespace tessera {

/// The samples of a slice as lines from the patient outwards, along x or y.
struct Outwards {
    int axis = 1;
    bool up = true;
    int lines(const glm::ivec3& extent) const { return extent[1 - axis]; }
    std::size_t at(const glm::ivec3& extent, int z, int line, int step) const {
        glm::ivec3 place(0, 0, z);
        place[axis] = up ? step : extent[axis] - 1 - step;
        place[1 - axis] = line;
        return linearIndex(place, extent);
    }
};
/// A side and the opposite one, two times.
constexpr std::array<Outwards, 4> kSides = {{{1, true}, {1, false}, {0, true}, {0, false}}};

/// Calls line(steps, at(step)) for all lines of all slices.
template <typename Line> void forLines(const Outwards& side, const glm::ivec3& extent, const Line& line) {
    for (int z = 0; z < extent.z; ++z)
        for (int n = 0; n < side.lines(extent); ++n)
            line(extent[side.axis], [&](int step) { return side.at(extent, z, n, step); });
}

/// Marks of the air that the borders of each slice reach: what is not firm.
Marks reached(const Marks& firm, const BodyGrid& grid);
/// Marks of what lies beyond all of the body on one side, of whole lines where there is no body.
Marks beyond(const Marks& body, const Outwards& side, const glm::ivec3& extent);
/// The number of lines that meet both the body and a marked sample.
std::size_t facingBody(const Marks& marks, const Marks& body, const Outwards& side, const glm::ivec3& extent);
/// Marks of every sample with a marked one among the 26 around it, or itself.
Marks dilated(const Marks& marks, const glm::ivec3& e);
/// Adds what is connected to the marked samples, by faces, through `open` alone, as far as mostMm.
void growInto(Marks& marks, const Marks& open, const BodyGrid& grid, double mostMm);
/// Marks that both have.
Marks both(const Marks& a, const Marks& b);

} // namespace tessera
