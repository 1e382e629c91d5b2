// bricking/import/source/blended_slices.h: values between two slices, for stacks with uneven steps.
#pragma once

#include "core/base/volume.h"

#include <cstddef>
#include <span>

namespace tessera {

/// Stored values of the type: (1 - weight) * lower + weight * upper, whole ones rounded. All are as long.
void blendSlices(ValueType type, std::span<const std::byte> lower, std::span<const std::byte> upper,
                 float weight, std::span<std::byte> out);

} // namespace tessera
