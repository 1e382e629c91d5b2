// viewer/window/cut_handles.h: the crop box and oblique cutting planes: their part of the panel, and handles
// on the picture that move planes and the box's sides.
#pragma once

#include "viewer/window/picture_view.h" // Area
#include "viewer/window/window_state.h"

#include <cstddef>
#include <glm/vec2.hpp>
#include <optional>

namespace tessera {

class CutHandles {
  public:
    void panel(WindowState& desk);
    /// Drawn over the picture; before the camera's input. Returns true if a handle takes the mouse.
    bool handle(WindowState& desk, const Area& area);
    void draw(const WindowState& desk, const Area& area) const;

    /// A box around the whole volume, or none.
    void toggleBox(WindowState& desk);
    /// Adds a plane through the crosshair that faces the viewer and removes what is in front of it.
    void addPlane(WindowState& desk);

  private:
    void boxes(WindowState& desk);
    void planes(WindowState& desk);

    std::optional<std::size_t> held_; // the dragged handle, in the order of planes and the sides of the box
};

} // namespace tessera
