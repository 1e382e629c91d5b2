// tests/render/light_reference_test.cpp: occlusion and shadows as the reference has them
#include "render/engines/reference/reference_engine.h"
#include "render/engines/reference/reference.h"
#include "core/image_metrics.h"
#include "render/light/stored_light.h"
#include "tests/support/mixed_fixture.h"
#include "tests/support/native_fixture.h"
#include <chrono>
#include <cstdio>
#include <gtest/gtest.h>

namespace tessera::test {
namespace {

Scene litScene(const std::string& store, const std::string& preset, int camera, Lighting lighting,
               const glm::ivec2& size = {24, 24}) {
    Scene scene = sceneOn(infoOf(store), preset, camera, size);
    scene.lighting = std::move(lighting);
    return scene;
}
Image reference(Prepared& prepared, const Scene& scene, double tolerance, int panels = 1) {
    const ScenePlan& p = prepared.p;
    const ReferenceInput input{p.volume.cache.get(), &p.info(), &p.volume.function, scene.shading, &p.volume.statistics, panels,
        {}, {}, p.view.lighting, p.view.camera, tolerance};
    Image image(p.view.imageSize);
    const auto values = renderReference(input, referenceRays(p.view.camera, p.info(), p.view.imageSize), 1);
    std::transform(values.begin(), values.end(), image.pixels.begin(), [](const glm::dvec4& v) { return glm::vec4(v); });
    return image;
}

TEST(LightReference, Cost) {
    Lighting all;
    all.occlusion = Occlusion{};
    Light light;
    light.kind = LightKind::directional;
    light.direction = {-1, 1, 1};
    light.shadow = true;
    all.lights = {light};
    for (int which = 0; which < 4; ++which) {
        Lighting l = all;
        if (which == 0 || which == 3) l.lights = {Light{}};
        if (which == 1 || which == 3) l.occlusion.reset();
        for (const char* preset : {"soft-tissue", "bone"}) {
            const Scene scene = litScene("torso", preset, 0, l, {16, 16});
            Prepared prepared("torso", scene);
            Image truth;
            for (const double tolerance : {1e-5, 1e-4, 1e-3, 3e-3, 1e-2}) {
                const std::clock_t start = std::clock();
                Image image = reference(prepared, scene, tolerance);
                if (tolerance == 1e-5) truth = image;
                const ImageDifference d = compare(image, truth);
                std::printf("%d %s %g: %.2f s rms %g max %g\n", which, preset, tolerance,
                            double(std::clock() - start) / CLOCKS_PER_SEC, d.rms, d.maxAbs);
                std::fflush(stdout);
                if (which == 3) break;
            }
        }
    }
}

} // namespace
} // namespace tessera::test
