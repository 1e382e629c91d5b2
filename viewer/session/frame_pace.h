// viewer/session/frame_pace.h: the number of pixels of an interactive picture within its time.
#pragma once

#include <glm/vec2.hpp>

namespace tessera {

/// Learns the time per pixel from drawn pictures. Sizes change in steps, so that noise of the clock does not
/// change them.
class FramePace {
  public:
    /// @param frameMs  time for a picture, positive
    explicit FramePace(double frameMs) : frameMs_(frameMs) {}

    /// Reports the time of a picture, as far as it depends on pixels.
    void drew(const glm::ivec2& size, double ms);
    /// Size of the next picture: the whole size, or a part of its width and height, at least an eighth of
    /// each and a pixel.
    glm::ivec2 sizeFor(const glm::ivec2& whole) const;
    /// Resets the time per pixel, after a change of function, volume or light.
    void forget() { msPerPixel_ = 0; }

  private:
    double frameMs_;
    double msPerPixel_ = 0; // 0: unknown
    mutable int step_ = 0;  // in steps of kStep, of the last size
};

} // namespace tessera
