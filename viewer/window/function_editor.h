// viewer/window/function_editor.h: the editor of the transfer function, drawn over the volume's histogram.
#pragma once

#include "viewer/window/window_state.h"

#include <cstddef>
#include <imgui.h>
#include <optional>

namespace tessera {

/// A part of a panel. Points are dragged; a click beside them adds one, a right click removes one; a double
/// click on a point asks for its colour. The histogram is of logarithms.
class FunctionEditor {
  public:
    void draw(WindowState& desk);

  private:
    void presets(WindowState& desk);
    void files(WindowState& desk); // of presets
    void curve(WindowState& desk);
    void axis(ImDrawList& draw, const ImVec2& corner, float width) const;
    void showAll(const VolumeSeen& volume);
    void colourOf(WindowState& desk);

    char name_[256] = {};             // of a preset or a file
    std::optional<std::size_t> held_; // opacity point
    std::size_t coloured_ = 0;        // whose colour is being edited
    double from_ = 0, to_ = 0;        // visible range of values
    const VolumeSeen* of_ = nullptr;
};

} // namespace tessera
