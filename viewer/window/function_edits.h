// viewer/window/function_edits.h: edits of a transfer function; each returns a new one. Values are in
// physical units.
#pragma once

#include "core/scene/transfer_function.h"

#include <cstddef>

namespace tessera {

/// Moves all points (opacities, colours, materials) by `shift`, and stretches them about the middle of the
/// opacity points by the factor.
TransferFunction shiftedAndStretched(const TransferFunction& function, double shift, double factor);
/// Moves the opacity point, but not past its neighbours.
/// @param point  index
TransferFunction withPointAt(const TransferFunction& function, std::size_t point, double value,
                             double opacity);
/// Adds an opacity point on the function; `index` gets its number.
TransferFunction withNewPoint(const TransferFunction& function, double value, double opacity,
                              std::size_t& index);
/// Removes an opacity point, unless it is the last one.
TransferFunction withoutPoint(const TransferFunction& function, std::size_t point);
/// The first value at half of the greatest opacity, within the range; the range's middle without opacity.
double halfOpaqueValue(const TransferFunction& function, double lowest, double highest);
/// Sets the colour of the colour point nearest to the value, or of a new one if none is within `reach`.
TransferFunction withColourAt(const TransferFunction& function, double value, const glm::dvec3& colour,
                              double reach);

} // namespace tessera
