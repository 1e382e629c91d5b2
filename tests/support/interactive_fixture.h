// tests/support/interactive_fixture.h: an interactive renderer with all that it stands on, which checks
// itself after every step.
#pragma once

#include "core/base/error.h"
#include "render/backends/gpu/gl/context.h"
#include "render/backends/gpu/gpu_engine.h"
#include "render/backends/native/native_engine.h"
#include "render/interactive/interactive_renderer.h"
#include "tests/support/scene_fixture.h"

#include <array>
#include <chrono>
#include <filesystem>
#include <gtest/gtest.h>
#include <memory>
#include <optional>
#include <string>

namespace tessera::test {

inline constexpr std::size_t kRam = std::size_t{256} << 20;

inline Scene interactiveScene(const std::string& preset, int camera, const glm::ivec2& size = {64, 64}) {
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    Scene scene = sceneOn(StoreReader(storePath("torso"), ram).info(), preset, camera, size);
    scene.quality.terminationTransmittance = 1e-3;
    return scene;
}

/// A renderer with all that it stands on.
struct Session {
    explicit Session(const Scene& scene, std::size_t gpuBytes, InteractiveOptions options = {},
                     const std::filesystem::path& store = storePath("torso"), bool native = false)
        : ram("RAM", "--ram", kRam), gpu("GPU memory", "--gpu-memory", gpuBytes), reader(store, ram),
          context(native ? nullptr : std::make_unique<GlContext>(GlDeviceChoice{"software"})),
          engine(native ? std::unique_ptr<Engine>(std::make_unique<NativeEngine>(options.threads, gpu, ram))
                        : std::make_unique<GpuEngine>(*context, gpu, ram)),
          renderer(scene, reader, *engine, ram, gpu, options) {}

    void checkStep() {
        EXPECT_LE(gpu.usedBytes(), gpu.limitBytes());
        EXPECT_LE(ram.usedBytes(), ram.limitBytes());
        const Selection& s = renderer.resident();
        EXPECT_LE(pagesFor(s.counts), renderer.atlasPages());
        // What rays are told is what the atlas holds.
        std::array<std::size_t, kLevelCount + 1> counts{};
        for (std::size_t b = 0; b < s.levels.size(); ++b) {
            ++counts[s.levels[b]];
            const std::optional<int> held = renderer.bricks().residentLevel(b);
            ASSERT_EQ(held.has_value(), s.levels[b] < kLevelCount - 1) << b;
            ASSERT_TRUE(!held || *held == s.levels[b]) << b;
        }
        EXPECT_EQ(counts, s.counts);
    }
    /// Pictures until it has converged; at most so many calls.
    int converge(std::chrono::milliseconds each = std::chrono::milliseconds(200), int most = 500) {
        int calls = 0;
        for (bool converged = false; !converged; ++calls) {
            if (calls >= most) {
                ADD_FAILURE() << "no end after " << calls << " calls";
                break;
            }
            converged = renderer.advance(InteractiveRenderer::Clock::now() + each).converged;
            checkStep();
        }
        return calls;
    }
    MemoryBudget ram, gpu;
    StoreReader reader;
    std::unique_ptr<GlContext> context; // of the GPU ray caster
    std::unique_ptr<Engine> engine;
    InteractiveRenderer renderer;
};

/// GPU memory of a scene for so many pages besides its pictures and tables.
inline std::size_t gpuBytesFor(const Scene& scene, std::size_t pages) {
    Session probe(scene, std::size_t{1} << 30);
    return probe.gpu.usedBytes() -
           atlasBytes(probe.renderer.atlasPages(), ValueType::i16, probe.engine->limits()) +
           atlasBytes(pages, ValueType::i16, TextureLimits{}) + (std::size_t{3} << 20);
}
/// The same for either engine. The native one's pages are larger where memory is ample (ghost layers), so
/// that its budget is found by asking.
inline std::size_t gpuBytesFor(const Scene& scene, std::size_t pages, bool native) {
    if (!native)
        return gpuBytesFor(scene, pages);
    std::size_t few = 0, enough = std::size_t{256} << 20;
    while (enough - few > std::size_t{1} << 16) {
        const std::size_t middle = (few + enough) / 2;
        std::size_t held = 0;
        try {
            held = Session(scene, middle, {}, storePath("torso"), true).renderer.atlasPages();
        } catch (const InputError&) { // not even one
        }
        (held < pages ? few : enough) = middle;
    }
    return enough;
}

} // namespace tessera::test
