// viewer/window/mesh_panel.h: the panel of a scene's meshes: which of them show, their colours and opacities.
#pragma once

#include "viewer/window/window_state.h"

#include <cstddef>
#include <string>

namespace tessera {

class MeshPanel {
  public:
    /// Needs an open volume whose scene has meshes.
    void draw(WindowState& desk);

  private:
    void row(WindowState& desk, std::size_t number);
    void look(WindowState& desk);

    std::size_t look_ = 0; // of the popup
    bool opensLook_ = false;
};

} // namespace tessera
