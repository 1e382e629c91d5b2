// bricking/levels/graded_rays.h: gradient opacity of sampled rays (brick_rays.h). A ray knows the value's
// change along itself, at every level, as far as that level's gradients reach. Across the ray the change is
// taken to be as large, as it is in the mean over directions. So predicted errors hold the gradients that
// coarser levels lose.
#pragma once

#include "core/scene/gradient_opacity.h"

#include <cstdint>
#include <span>

namespace tessera {

/// Factors of a ray's segments.
/// @param perMm  its points, per mm
/// @param codes  of the segments' middles at the level
/// @param valuePerCode  physical units, not negative
void gradedFactors(const GradientOpacity& perMm, std::span<const std::uint8_t> codes, int level,
                   double valuePerCode, double segmentMm, std::span<double> factors);

} // namespace tessera
