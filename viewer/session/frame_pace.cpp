// viewer/session/frame_pace.cpp: see frame_pace.h.
#include "viewer/session/frame_pace.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

namespace tessera {
namespace {

constexpr int kSmallest = 12;          // steps from a whole picture to an eighth of its width
constexpr double kStepsPerHalving = 4; // of the width
constexpr double kAtFirst = 6;         // step of a picture whose pixels' cost is not known
constexpr double kSlack = 0.6;         // of a step: larger pictures only where they clearly fit

double partOf(int step) {
    return std::exp2(-step / kStepsPerHalving);
}

} // namespace

void FramePace::drew(const glm::ivec2& size, double ms) {
    const double cost = ms / (static_cast<double>(size.x) * size.y);
    // Dearer at once, cheaper slowly: a picture that comes late is worse than one that is coarse.
    msPerPixel_ = msPerPixel_ == 0 || cost > msPerPixel_ ? cost : 0.7 * msPerPixel_ + 0.3 * cost;
}

glm::ivec2 FramePace::sizeFor(const glm::ivec2& whole) const {
    double step = kAtFirst;
    if (msPerPixel_ > 0) {
        const double part = std::sqrt(frameMs_ / (msPerPixel_ * static_cast<double>(whole.x) * whole.y));
        step = -kStepsPerHalving * std::log2(part);
    }
    int next = static_cast<int>(std::ceil(std::clamp(step, 0.0, static_cast<double>(kSmallest))));
    if (next == step_ - 1 && step > next - 1 + kSlack)
        next = step_;
    step_ = next;
    return glm::max(glm::ivec2(glm::round(glm::dvec2(whole) * partOf(next))), glm::ivec2(1));
}

} // namespace tessera
