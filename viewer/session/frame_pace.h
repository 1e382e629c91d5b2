// viewer/session/frame_pace.h: the number of pixels that a moving picture may have to be there in time.
#pragma once

#include <glm/vec2.hpp>

namespace tessera {

/// Learns what a pixel costs from the pictures that were drawn. Sizes go in steps, so that pictures do not
/// change their size at every noise of the clock.
class FramePace {
  public:
    /// @param frameMs  that a picture may take, positive
    explicit FramePace(double frameMs) : frameMs_(frameMs) {}

    /// A picture of so many pixels took so long, as far as pixels decide about it.
    void drew(const glm::ivec2& size, double ms);
    /// What the next one may have, of a whole picture: all of it, or a part of its width and height, at least
    /// an eighth of each and a pixel.
    glm::ivec2 sizeFor(const glm::ivec2& whole) const;
    /// Forgets what a pixel costs: another function, volume or light.
    void forget() { msPerPixel_ = 0; }

  private:
    double frameMs_;
    double msPerPixel_ = 0; // 0: not known
    mutable int step_ = 0;  // of kStep, as last given
};

} // namespace tessera
