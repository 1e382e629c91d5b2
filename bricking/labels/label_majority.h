// bricking/labels/label_majority.h: the levels of a volume of labels: the majority of 2^3.
#pragma once

#include "bricking/store/pyramid.h"

#include <cstdint>
#include <span>

namespace tessera {

/// kMajorityRule, for u8 and u16: of the eight samples the value that most of them have. A tie goes to the
/// value that fewer voxels of level 0 have, so that thin structures stay; then to the lower value.
/// @param voxelsOf  at level 0, of every value that occurs
PyramidRule majorityRule(std::span<const std::uint64_t> voxelsOf);

} // namespace tessera
