// bricking/analysis/body/mark_parts.h: the connected parts of a set of voxels, and the choice among them.
// Internal to this room.
#pragma once

#include "bricking/analysis/body/marks.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>

namespace tessera {

/// Voxels that are connected by faces.
struct MarkPart {
    glm::ivec3 low, high;   // of its box; high beyond the last voxel
    bool isMeeting = false; // some of its voxels are marked in the other set too
    std::uint32_t voxels = 0;
};
enum class Connected : std::uint8_t { throughSlices, inSlices };

/// The voxels of the parts of `marks` that keep() chooses.
/// @param other  what MarkPart::isMeeting speaks of
Marks chosenParts(const Marks& marks, Connected connected, const Marks& other,
                  const std::function<bool(const MarkPart&)>& keep);
/// Memory that it takes at most, besides its result.
std::size_t partsBytes(const glm::ivec3& extent);

} // namespace tessera
