// viewer/window/cut_handles.h: the crop box and oblique cutting planes: their part of the panel, and handles
// on the picture that push planes and the box's sides.
#pragma once

#include "viewer/window/desk.h"
#include "viewer/window/picture_view.h" // Area

#include <cstddef>
#include <glm/vec2.hpp>
#include <optional>

namespace tessera {

class CutHandles {
  public:
    void panel(Desk& desk);
    /// Over the picture; before the camera's hand. Returns whether a handle takes the mouse.
    bool handle(Desk& desk, const Area& area);
    void draw(const Desk& desk, const Area& area) const;

    /// A box around the whole volume, or none.
    void toggleBox(Desk& desk);
    /// A plane through the crosshair that faces the viewer and cuts away what is before it.
    void addPlane(Desk& desk);

  private:
    void boxes(Desk& desk);
    void planes(Desk& desk);

    std::optional<std::size_t> held_; // that is dragged, in the order of planes and the sides of the box
};

} // namespace tessera
