// tests/bench/tessera_peer.h: Tessera's GPU ray caster beside other renderers: a scene on the device, drawn
// with any integrator, fetch and step.
#pragma once

#include "core/image/image.h"
#include "core/scene/scene.h"
#include "render/backends/gpu/gl/context.h"
#include "tests/bench/bench_tools.h"

#include <string>
#include <vector>

namespace tessera::bench {

/// Tessera with one integrator and one way to fetch.
struct Variant {
    Integrator integrator;
    Fetch fetch;
    std::string name() const;
};
/// All of the integrators with all of the fetches, both with commas between. Throws InputError for names that
/// are none, and for "auto".
std::vector<Variant> parseVariants(const std::string& integrators, const std::string& fetches);

/// Makes a GL context, which is current on the calling thread; all calls come from that one.
class TesseraScene {
  public:
    TesseraScene(const Scene& scene, const StoreReader& store, const std::string& device, Budgets& budgets);
    const FramePlan& prepared() const { return onDevice_.prepared(); }
    std::string device() const { return context_.renderer(); }
    /// The tables are made beforehand: they are a scene's, not a frame's.
    Optics optics(Integrator integrator, double stepVoxels) const;
    /// Milliseconds of one frame; its work is counted only with `counting`, which takes time.
    double draw(const Optics& optics, double stepVoxels, Fetch fetch, bool counting, Image& picture,
                Work& work);

  private:
    Scene scene_;
    Budgets& budgets_;
    GlContext context_;
    SceneOnDevice onDevice_;
};

} // namespace tessera::bench
