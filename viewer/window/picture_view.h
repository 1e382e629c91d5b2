// viewer/window/picture_view.h: the volume's picture in the window, and mouse and keys on it.
#pragma once

#include "viewer/window/window_state.h"

#include <cstdint>
#include <glm/vec2.hpp>
#include <memory>

namespace tessera {

class Beside;

/// A rectangle of the window, in the screen's units, and the pixels per unit.
struct Area {
    glm::dvec2 from{0}, size{0};
    double pixelsPerUnit = 1;
    glm::ivec2 pixels() const;
    /// A position in the window, in pixels of the picture.
    glm::dvec2 pictureFromWindow(const glm::dvec2& place) const { return (place - from) * pixelsPerUnit; }
};

/// The texture; a GL context must be current for its lifetime.
class PictureTexture {
  public:
    PictureTexture();
    ~PictureTexture();
    PictureTexture(const PictureTexture&) = delete;
    PictureTexture& operator=(const PictureTexture&) = delete;
    /// Uploads a picture's pixels; no work for the same picture.
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
    /// Once a frame, while ImGui's frame is open. Returns true while held input moves the camera.
    /// @param area  of the picture under the pointer: that of the scan beside the first, if one is given
    bool handle(WindowState& desk, const Area& area, Beside* beside = nullptr);
    /// A pressed key by GLFW's name: a letter's capital in ASCII.
    void press(WindowState& desk, int key, bool control, bool shift);
    /// The pointer over the picture, pixels; after a rest the point under it is requested.
    const glm::dvec2& pointer() const { return pointer_; }
    bool isOver() const { return over_; }
    /// The scan whose picture was handled last; null: the first.
    const Beside* beside() const { return beside_; }

  private:
    enum class Drag { none, orbit, pan, zoom, roll, window };
    bool fly(WindowState& desk);
    void drag(WindowState& desk, const Area& area, const glm::dvec2& delta);

    Drag drag_ = Drag::none;
    bool over_ = false;
    const Beside* beside_ = nullptr;
    glm::dvec2 pointer_{0}, pickedAt_{-1, -1};
    std::uint64_t pickedFor_ = 0; // the request
    WindowClock::time_point pointerMoved_;
    std::uint64_t centreOn_ = 0; // the request whose answer becomes the centre
    std::uint64_t aloneOn_ = 0;  // the request whose answer has the labels to show alone
    WindowClock::time_point flewAt_;
};

} // namespace tessera
