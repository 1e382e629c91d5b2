// viewer/window/overlays.h: what is written over the picture: which way the patient lies, how large things
// are, what is under the pointer, how good the picture is.
#pragma once

#include "viewer/window/desk.h"
#include "viewer/window/picture_view.h"

#include <glm/vec3.hpp>

namespace tessera {

/// Of the current frame, over the picture.
void drawOverlays(Desk& desk, const Area& area, const PictureHand& hand);

/// Where a place lies on the picture, pixels; false behind the eye.
bool pictureFromPatient(const Camera& camera, const glm::ivec2& imageSize, const glm::dvec3& mm,
                        glm::dvec2& pixel);

/// A length of 1, 2 or 5 times a power of ten that is at most `mm`, mm.
double roundLength(double mm);

} // namespace tessera
