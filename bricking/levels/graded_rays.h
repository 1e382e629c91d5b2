// bricking/levels/graded_rays.h: gradient opacity of sampled rays (brick_rays.h). A ray has the change of the
// value along itself at every level. The change across the ray is assumed equal, as in the mean over
// directions. So predicted errors include gradients that coarser levels lose.
#pragma once

#include "core/scene/transfer_function.h"

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
