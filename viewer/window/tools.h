// viewer/window/tools.h: tools that take clicks and outlines on the picture or a plane from the camera:
// measured points, and scissors.
#pragma once

#include "viewer/window/picture_view.h" // Area
#include "viewer/window/window_state.h"

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

namespace tessera {

class Tools {
  public:
    enum class Tool { none, distance, angle, circle, scissorsInside, scissorsOutside };

    /// Parts of the panel: what measures, and scissors.
    void panel(WindowState& desk);
    void scissorsPanel(WindowState& desk);
    /// Over the picture; before the camera's hand. Returns whether the tool takes the mouse.
    bool handle(WindowState& desk, const Area& area);
    /// A place on a plane was clicked: a point of what is being measured. Returns whether a tool took it.
    bool placed(WindowState& desk, const glm::dvec3& mm);
    /// Measurements and the outline, over the picture.
    void draw(WindowState& desk, const Area& area) const;
    void stop();
    /// Takes a tool in hand, in place of another; the same one again lays it down.
    void take(Tool tool);
    Tool tool() const { return tool_; }

  private:
    void button(const char* name, Tool tool);
    bool measures() const { return tool_ == Tool::distance || tool_ == Tool::angle || tool_ == Tool::circle; }

    Tool tool_ = Tool::none;
    Measurement pending_;             // points so far
    std::uint64_t question_ = 0;      // of a click; 0: none
    std::vector<glm::dvec2> outline_; // pixels of the picture
    bool drawing_ = false;
};

} // namespace tessera
