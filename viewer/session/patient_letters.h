// viewer/session/patient_letters.h: the patient's directions in letters, as DICOM writes them in Patient
// Orientation (0020,0020): right R and left L, anterior A and posterior P; superior S and inferior I, for
// which DICOM writes H and F.
#pragma once

#include "core/scene/camera.h"

#include <glm/vec3.hpp>
#include <string>

namespace tessera {

/// Letters of a direction in patient space (LPS), the nearest axis first. A second one stands where the
/// direction leaves the first axis by more than 10 degrees towards another: "R", "RA". "" for no direction.
std::string directionLetters(const glm::dvec3& direction);

/// The directions that a picture's edges lie in, seen from its centre.
struct EdgeLetters {
    std::string left, right, top, bottom;
    bool operator==(const EdgeLetters&) const = default;
};
EdgeLetters edgeLetters(const Camera& camera);

} // namespace tessera
