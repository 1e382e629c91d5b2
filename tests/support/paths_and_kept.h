// tests/support/paths_and_kept.h: pictures by paths, and of kept light, in which media answer to the same
// light: of intensity 4 to paths, of 1 to the contract's volume (docs/sampling.md, "Paths": units). There is
// no other light: what ambient light occlusion leaves is nearly none.
#pragma once

#include "core/scene/preset.h"
#include "render/picture/render_scene.h"
#include "tests/support/scene_fixture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>

namespace tessera::test {

class PathsAndKept {
  public:
    /// @param light    alone; kept light has it as it is
    /// @param g        of paths' phase function, Henyey and Greenstein's
    /// @param camera   of sceneOn()
    PathsAndKept(const std::string& store, const std::string& preset, const Light& light, int edge,
                 int samples, double g = 0, int camera = 0)
        : ram_("RAM", "--ram", std::size_t{3} << 30),
          gpu_("GPU memory", "--gpu-memory", std::size_t{3} << 30), reader_(store, ram_),
          scene_(sceneOn(reader_.info(), preset, camera, {edge, edge})) {
        TransferFunction function = presetFunction(preset, {-1000, 2000, true, 1, {}});
        function.setMaterials({});
        scene_.volumes[0].path = store;
        scene_.volumes[0].transferFunction = function;
        scene_.quality.integrator = Integrator::midpoint;
        scene_.quality.pixels.samples = samples;
        scene_.shading.ambient = scene_.shading.diffuse = 1;
        scene_.shading.specular = 0;
        scene_.shading.gradientWeight = GradientWeight{1e6, 2e6}; // no place is a surface
        scene_.lighting.lights = {light};
        Scene paths = scene_;
        paths.lighting.lights[0].intensity = 4;
        paths.lighting.transport.emplace();
        paths.lighting.transport->bounces = 64;
        paths.lighting.transport->phase.g = g;
        scene_.lighting.occlusion = Occlusion{.rays = 8, .radiusMm = 8, .bias = 0, .gamma = 8};
        truth_ = draw(paths);
        paths.lighting.transport->bounces = 1;
        once_ = draw(paths);
        without_ = draw(scene_);
    }
    /// Draws kept light with light that tissue scatters.
    void scatter(const std::function<void(Lighting&)>& change) {
        Scene kept = scene_;
        kept.lighting.lights[0].scatter = 1;
        change(kept.lighting);
        with_ = draw(kept);
    }
    /// The factor by which kept light comes nearest to paths of one scattering: what the phase function makes
    /// of the angle between light and viewer.
    double ofPhase() const {
        double product = 0, square = 0;
        each([&](const auto& of) {
            product += of(once_, 0) * of(without_, 0) + of(once_, 1) * of(without_, 1);
            square += of(without_, 0) * of(without_, 0) + of(without_, 1) * of(without_, 1);
        });
        return square > 0 ? product / square : 1;
    }
    /// The noise of two pictures by paths is independent: its mean product is none. Scattered light is linear
    /// in its factor.
    /// @param ofAll  all light; else what further scatterings add, beside what scattered light adds
    /// @param phase  factor on kept light
    double rms(double scatter, bool ofAll = false, double phase = 1) const {
        double sum = 0;
        std::size_t shown = 0;
        each([&](const auto& of) {
            ++shown;
            double difference[2];
            for (const int seed : {0, 1}) {
                const double added = scatter > 0 ? scatter * (of(with_, seed) - of(without_, seed)) : 0;
                difference[seed] = ofAll ? phase * (of(without_, seed) + added) - of(truth_, seed)
                                         : phase * added - (of(truth_, seed) - of(once_, seed));
            }
            sum += difference[0] * difference[1];
        });
        return std::sqrt(std::max(0.0, sum / static_cast<double>(std::max<std::size_t>(1, shown))));
    }
    /// Of factors in steps of 0.05 up to 8 the one with the least rms.
    double bestFactor(bool ofAll, double phase) const {
        double least = rms(0, ofAll, phase), best = 0;
        for (double factor = 0.05; factor <= 8; factor += 0.05)
            if (const double error = rms(factor, ofAll, phase); error < least)
                least = error, best = factor;
        return best;
    }
    const Image& truth() const { return truth_[0]; }
    const Image& without() const { return without_[0]; }
    const Image& with() const { return with_[0]; }

  private:
    using Two = std::array<Image, 2>; // of two seeds
    /// visit(of), of every channel of every pixel that shows something: of(pictures, seed).
    template <typename Visit> void each(const Visit& visit) const {
        for (std::size_t n = 0; n < truth_[0].pixels.size(); ++n)
            for (int c = 0; c < 3 && without_[0].pixels[n].a > 0; ++c)
                visit([&](const Two& pictures, int seed) {
                    return static_cast<double>(pictures[static_cast<std::size_t>(seed)].pixels[n][c]);
                });
    }
    Two draw(Scene scene) {
        Two pictures;
        RenderOptions options;
        options.engine = EngineKind::native;
        for (const unsigned seed : {0u, 1u}) {
            scene.quality.pixels.seed = seed;
            pictures[seed] = renderScene(scene, reader_, ram_, gpu_, options).image;
        }
        return pictures;
    }
    MemoryBudget ram_, gpu_;
    StoreReader reader_;
    Scene scene_;
    Two truth_, once_, without_, with_;
};

} // namespace tessera::test
