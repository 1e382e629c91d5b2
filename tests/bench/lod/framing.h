// tests/bench/lod/framing.h: measures how well a picture is filled, and whether it cuts anything off.
#pragma once

#include "core/image/image.h"

namespace tessera::bench {

/// Opacity from which a pixel counts as showing something.
constexpr float kShownOpacity = 0.02f;

struct Framing {
    double span = 0;  // of the box around what shows: the larger of its shares of the width and the height
    double share = 0; // of the picture's pixels that show something
    int cutOff = 0;   // pixels at the picture's border that show something
};
Framing framingOf(const Image& image);

} // namespace tessera::bench
