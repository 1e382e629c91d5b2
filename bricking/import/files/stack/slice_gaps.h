// bricking/import/files/stack/slice_gaps.h: a stack with missing slices, which are interpolated between their
// neighbours. Private to stacks.
#pragma once

#include "bricking/import/source/slab_source.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace tessera {

/// Memory holds two slices.
/// @param slices  those that there are
/// @param places  of each in the whole stack; ascending, the first is 0
std::unique_ptr<RandomSlabSource> fillGaps(std::unique_ptr<RandomSlabSource> slices,
                                           const std::vector<std::uint64_t>& places);

} // namespace tessera
