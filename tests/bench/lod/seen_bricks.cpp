// tests/bench/lod/seen_bricks.cpp: see seen_bricks.h.
#include "tests/bench/lod/seen_bricks.h"

#include "core/base/threads.h"
#include "render/contract/lattice.h"
#include "render/contract/sampler.h"

#include <mutex>

namespace tessera::bench {
namespace {

struct Sums {
    std::vector<float> light; // of what passes all before the brick, per ray that crosses it
    std::vector<std::uint32_t> rays;
    explicit Sums(std::size_t bricks) : light(bricks), rays(bricks) {}
};

void followRay(const SegmentedRay<float>& ray, const FramePlan& scene, const Selection& culled,
               LatticeReader& samples, Sums& sums) {
    float through = 1;
    std::size_t last = culled.levels.size();
    for (int i = 0; i < ray.count; ++i) {
        const float length = strideLength(ray, i, 1);
        const glm::vec3 p = stridePosition(ray, i, length);
        const glm::ivec3 at = glm::clamp(glm::ivec3(p) / kBrickExtent, glm::ivec3(0), culled.bricks - 1);
        const std::size_t brick = linearIndex(at, culled.bricks);
        if (brick != last) {
            last = brick;
            sums.light[brick] += through;
            ++sums.rays[brick];
        }
        if (culled.levels[brick] == Selection::kEmpty || through <= 0)
            continue;
        const glm::vec4 optical = lookUp(scene.layer().optics, fieldValue(samples, p, 1.0f));
        through *= 1 - opacityOf(optical.a * (length * ray.segmentMm));
        if (through < scene.layer().optics.termination)
            through = 0;
    }
}

} // namespace

std::vector<float> seenBricks(const FramePlan& scene, const Selection& culled, int pixels) {
    const RayFrame<float> frame =
        cast<float>(rayFrame(scene.view.camera, scene.info(), glm::ivec2(pixels), 1.0));
    Sums all(culled.levels.size());
    std::mutex mutex;
    parallelFor(static_cast<std::size_t>(pixels), 0, [&](std::size_t row) {
        Sums mine(culled.levels.size());
        LatticeReader samples(*scene.layer().cache, scene.info(), 0, &culled);
        for (int x = 0; x < pixels; ++x)
            followRay(
                segmentedRay(frame, glm::vec2(static_cast<float>(x) + 0.5f, static_cast<float>(row) + 0.5f)),
                scene, culled, samples, mine);
        const std::lock_guard lock(mutex);
        for (std::size_t b = 0; b < all.light.size(); ++b) {
            all.light[b] += mine.light[b];
            all.rays[b] += mine.rays[b];
        }
    });
    for (std::size_t b = 0; b < all.light.size(); ++b)
        all.light[b] = all.rays[b] ? std::min(all.light[b] / static_cast<float>(all.rays[b]), 1.0f) : 1.0f;
    return all.light;
}

} // namespace tessera::bench
