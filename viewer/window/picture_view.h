// viewer/window/picture_view.h: the volume's picture in the window, and mouse and keys on it.
#pragma once

#include "viewer/window/window_state.h"

#include <cstdint>
#include <glm/vec2.hpp>
#include <memory>

namespace tessera {

/// A rectangle of the window, in the screen's units, and how many pixels one of them has.
struct Area {
    glm::dvec2 from{0}, size{0};
    double pixelsPerUnit = 1;
    glm::ivec2 pixels() const;
    /// A place of the window in pixels of the picture.
    glm::dvec2 pictureFromWindow(const glm::dvec2& place) const { return (place - from) * pixelsPerUnit; }
};

/// The texture; a GL context must be current from its making to its end.
class PictureTexture {
  public:
    PictureTexture();
    ~PictureTexture();
    PictureTexture(const PictureTexture&) = delete;
    PictureTexture& operator=(const PictureTexture&) = delete;
    /// Takes another picture's pixels; the same one again costs nothing.
    void show(const std::shared_ptr<const ShownPicture>& picture);
    unsigned name() const { return name_; }
    glm::ivec2 size() const { return size_; }

  private:
    unsigned name_ = 0;
    glm::ivec2 size_{0};
    std::shared_ptr<const ShownPicture> shown_;
};

/// Mouse and keys over the picture.
class PictureHand {
  public:
    /// Once a frame, while ImGui's frame is open. Returns whether something is held that moves on its own.
    bool handle(WindowState& desk, const Area& area);
    /// A key that went down, as GLFW names it: a letter's capital in ASCII.
    void press(WindowState& desk, int key, bool control, bool shift);
    /// Where the pointer rests over the picture, pixels; what is there is asked when it has rested.
    const glm::dvec2& pointer() const { return pointer_; }
    bool isOver() const { return over_; }

  private:
    enum class Drag { none, orbit, pan, zoom, roll, window };
    bool fly(WindowState& desk);
    void drag(WindowState& desk, const Area& area, const glm::dvec2& delta);

    Drag drag_ = Drag::none;
    bool over_ = false;
    glm::dvec2 pointer_{0}, pickedAt_{-1, -1};
    std::uint64_t pickedFor_ = 0; // the wish
    WindowClock::time_point pointerMoved_;
    std::uint64_t centreOn_ = 0; // the question whose answer comes to the middle
    WindowClock::time_point flewAt_;
};

} // namespace tessera
