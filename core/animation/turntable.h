// core/animation/turntable.h: a turntable film: a camera's circle about its focal point, as a path of
// keyframes.
#pragma once

#include "core/animation/path.h"

#include <cstddef>

namespace tessera {

/// One keyframe a frame, at equal angles about the patient's axis (from feet to head) through the camera's
/// focal point. With degrees above 0 the viewer moves towards the patient's left. Full turns leave out the
/// last frame, which would equal the first; others end at `degrees`. Throws InputError naming --turn and
/// --frames for an angle of 0 or more than 3600 degrees, and for fewer than 2 frames or more than a path may
/// have.
Path turntable(const Camera& first, double degrees, std::size_t frames, double framesPerSecond);

} // namespace tessera
