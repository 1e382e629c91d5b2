// viewer/cli/options/camera_words.h: the camera as options say it in words: a side or two angles, a
// projection, a fit, a scale.
#pragma once

#include "core/scene/scene.h"

#include <string>

namespace tessera {

// All throw InputError naming `where` for texts that mean nothing.

/// A side's name, or degrees: TURN,RISE.
void parseSide(const std::string& text, FittedView& view, const std::string& where);
/// Throws InputError for a camera with a position, and for a slice that is seen along its normal.
void setFit(Scene& scene, const std::string& text, const std::string& where);
/// A camera with a position shows the same at its focal point. Throws InputError for a slice that is seen
/// along its normal.
void setProjection(Scene& scene, const std::string& text, const std::string& where);
/// The edge of a pixel in mm, which only parallel pictures have. Throws InputError for a perspective one.
/// @param becomesParallel  a camera by side
void setScale(Scene& scene, double mmPerPixel, bool becomesParallel, const std::string& where);

} // namespace tessera
