// render/picture/frame_renderer.h: the pictures of a film. Each equals renderScene() of its scene, bit by
// bit. Whatever does not depend on the scene stays from one frame to the next: device and statistics. Bricks
// stay too where only the camera has moved and memory allows.
#pragma once

#include "render/picture/render_scene.h"

#include <cstddef>
#include <memory>
#include <span>

namespace tessera {

class FrameRenderer {
  public:
    /// Options as for renderScene(); its engine is chosen at once. Store and budgets outlive this.
    /// @param stores  of the scenes' volumes, in order
    FrameRenderer(Stores stores, MemoryBudget& ram, MemoryBudget& gpu, const RenderOptions& options);
    FrameRenderer(const StoreReader& store, MemoryBudget& ram, MemoryBudget& gpu,
                  const RenderOptions& options);
    ~FrameRenderer();
    FrameRenderer(const FrameRenderer&) = delete;
    FrameRenderer& operator=(const FrameRenderer&) = delete;

    /// Throws as renderScene() does; whatever it throws, the next call begins anew.
    RenderResult draw(const Scene& scene);
    /// Lets go of all bricks.
    void forget();

    /// For reports and tests.
    struct Kept {
        std::size_t frames = 0;  // that were drawn
        std::size_t goneOn = 0;  // of them with the bricks of the one before
        std::size_t brought = 0; // bytes of bricks, in all
    };
    const Kept& kept() const { return kept_; }

  private:
    struct State;
    std::unique_ptr<State> state_;
    Kept kept_;
};

} // namespace tessera
