// bricking/levels/graded_rays.h: opacity by gradient of sampled rays (brick_rays.h). They know how the value
// changes along themselves, at every level as far as that level's gradients reach; across, it is taken to
// change as much, as it does in the mean over directions. So what coarser levels lose of their gradients is
// in the errors that are predicted.
#pragma once

#include "core/gradient_opacity.h"

#include <cstdint>
#include <span>

namespace tessera {

/// Factors of a ray's segments. @param perMm  its points, per mm
/// @param codes         of the segments' middles at the level
/// @param valuePerCode  physical units, not negative
void gradedFactors(const GradientOpacity& perMm, std::span<const std::uint8_t> codes, int level,
                   double valuePerCode, double segmentMm, std::span<double> factors);

} // namespace tessera
