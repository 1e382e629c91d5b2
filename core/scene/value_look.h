// core/scene/value_look.h: the appearance of one value in modes that show single values, exactly and as the
// table of floats that engines read (docs/sampling.md, "Modes").
#pragma once

#include "core/scene/mode.h"
#include "core/scene/transfer_function.h"

#include <glm/vec3.hpp>

namespace tessera {

struct ValueLook {
    ValueColour colour = ValueColour::window;
    GreyWindow window;
};

/// Linear light: the window's grey, rising or falling, is a display value (sRGB), as in radiology viewers.
/// @param value  physical units
glm::dvec3 colourOfValue(const ValueLook& look, const TransferFunction& function, double value);

/// Colours by value. An entry's extinction says only whether values there can change what a ray of this
/// reduction shows, so that bricks are culled by it. The lowest entry cannot change a maximum, nor the
/// highest a minimum.
/// @param reduction  not composite
TransferTable valueTable(const ValueLook& look, const TransferFunction& function, Reduction reduction);

} // namespace tessera
