// core/animation/turntable.cpp: see turntable.h.
#include "core/animation/turntable.h"

#include "core/base/error.h"

#include <cmath>
#include <glm/trigonometric.hpp>
#include <string>

namespace tessera {

Path turntable(const Camera& first, double degrees, std::size_t frames, double framesPerSecond) {
    constexpr double kMostDegrees = 3600;
    if (!(std::abs(degrees) <= kMostDegrees) || degrees == 0)
        throw badFile("--turn", "degrees from -3600 to 3600, not 0", std::to_string(degrees));
    if (frames < 2 || frames > Path::kMostKeyframes)
        throw badFile("--frames", "of a turn from 2 to " + std::to_string(Path::kMostKeyframes) + " frames",
                      std::to_string(frames));
    const bool closes = std::fmod(degrees, 360.0) == 0;
    const double step = glm::radians(degrees) / static_cast<double>(closes ? frames : frames - 1);
    Path path;
    path.framesPerSecond = framesPerSecond;
    for (std::size_t n = 0; n < frames; ++n) {
        const double angle = step * static_cast<double>(n), c = std::cos(angle), s = std::sin(angle);
        // About +z, by the right hand: from the front, -y, towards the patient's left, +x.
        const auto turned = [&](const glm::dvec3& v) {
            return glm::dvec3(c * v.x - s * v.y, s * v.x + c * v.y, v.z);
        };
        Keyframe key;
        key.timeS = static_cast<double>(n) / framesPerSecond;
        key.easing = Easing::linear;
        key.camera = first;
        key.camera->position = first.focalPoint + turned(first.position - first.focalPoint);
        key.camera->viewUp = turned(first.viewUp);
        path.keyframes.push_back(key);
    }
    return path;
}

} // namespace tessera
