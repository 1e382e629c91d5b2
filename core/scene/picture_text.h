// core/scene/picture_text.h: text and rectangles that are drawn into pictures. A letter is 5 x 7 dots.
#pragma once

#include "core/image/image.h"

#include <glm/vec2.hpp>
#include <glm/vec4.hpp>
#include <string>

namespace tessera {

constexpr int kTextPitch = 6, kTextHeight = 7; // dots: from letter to letter; of a letter

/// Pixels of a dot in a picture of this size.
int textUnit(const glm::ivec2& imageSize);

/// A picture that is drawn on; what lies outside of it is left out.
class PicturePen {
  public:
    PicturePen(Image& image, const glm::vec4& colour) : image_(image), colour_(colour) {}
    /// Of whole pixels, [from, to).
    void fill(const glm::ivec2& from, const glm::ivec2& to);
    /// ASCII; other bytes leave a gap.
    /// @param at    upper left
    /// @param unit  pixels of a dot
    /// @param more  that every dot is larger on each side
    void write(glm::ivec2 at, const std::string& text, int unit, int more);

  private:
    Image& image_;
    glm::vec4 colour_;
};

} // namespace tessera
