// viewer/window/function_edits.h: edits of a transfer function; each returns a new one. Values are in
// physical units.
#pragma once

#include "core/scene/transfer_function.h"

#include <cstddef>

namespace tessera {

/// All points (opacities, colours, materials) go by `shift`, away from the middle of the opacity points by
/// the factor.
TransferFunction shiftedAndStretched(const TransferFunction& function, double shift, double factor);
/// The opacity point goes there, but not past its neighbours.
/// @param point  index
TransferFunction withPointAt(const TransferFunction& function, std::size_t point, double value,
                             double opacity);
/// Another opacity point, with what the function has there; `index` is what it becomes.
TransferFunction withNewPoint(const TransferFunction& function, double value, double opacity,
                              std::size_t& index);
/// Without an opacity point; the last one stays.
TransferFunction withoutPoint(const TransferFunction& function, std::size_t point);
/// Where it first comes to half of its greatest opacity, within the range; the range's middle where
/// it has none.
double halfOpaqueValue(const TransferFunction& function, double lowest, double highest);
/// The colour at the colour point nearest to the value, or at a new one where none is within `reach`.
TransferFunction withColourAt(const TransferFunction& function, double value, const glm::dvec3& colour,
                              double reach);

} // namespace tessera
