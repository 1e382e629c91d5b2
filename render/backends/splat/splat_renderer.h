// render/backends/splat/splat_renderer.h: the renderer that draws samples as splats (docs/sampling.md,
// "Splats"): slices of the volume front to back, each a sheet of footprints.
#pragma once

#include "core/base/budget.h"
#include "core/image/image.h"
#include "render/backends/splat/splat_batch.h"
#include "render/backends/splat/splat_settings.h"
#include "render/engine_traits.h"
#include "render/renderer.h"

#include <memory>
#include <string>

namespace tessera {

/// Of a picture.
struct SplatReport {
    SplatCounts counts;
    double secondsListing = 0, secondsDrawing = 0; // values read, classified and lit; projected and drawn
};

class SplatRenderer : public Renderer {
  public:
    explicit SplatRenderer(const EngineInput& input, const SplatSettings& settings = {});

    Engine::About about() const override;
    /// Memory besides the volume's cache and the picture is charged to context.gpu, as that of rays is on the
    /// native engine.
    bool draw(const FrameTask& task, RenderResult& result, Image& added) override;
    std::unique_ptr<PixelSource> pixels(const FrameTask& task) override;
    void endFrame() override;
    const SplatReport& report() const { return report_; }

  private:
    int threads_;
    SplatSettings settings_;
    SplatReport report_;
    Image picture_; // of the frame just drawn
    Charge pictureCharge_;
};

/// Why splats cannot be drawn; empty: they can.
std::string splatDeclines(const Scene& scene, const RenderOptions& options);

EngineTraits splatTraits();

} // namespace tessera
