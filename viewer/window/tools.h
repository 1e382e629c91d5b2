// viewer/window/tools.h: tools that use clicks and outlines on the picture or a plane instead of the camera:
// measurements and scissors.
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

    /// Parts of the panel: measurements, and scissors.
    void panel(WindowState& desk);
    void scissorsPanel(WindowState& desk);
    /// Drawn over the picture; before the camera's input. Returns true if the tool takes the mouse.
    bool handle(WindowState& desk, const Area& area);
    /// Handles a click on a plane: a point of the current measurement. Returns true if a tool took it.
    bool placed(WindowState& desk, const glm::dvec3& mm);
    /// Draws measurements and the outline, over the picture.
    void draw(WindowState& desk, const Area& area) const;
    void stop();
    /// Selects a tool; the same one again deselects it.
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
