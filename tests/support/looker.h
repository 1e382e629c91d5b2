// tests/support/looker.h: a session and what a window does with it, for tests: asks, and waits until what it
// asked for is there.
#pragma once

#include "bricking/store/store_reader.h"
#include "core/scene/scene.h"
#include "render/picture/render_scene.h"
#include "viewer/session/view_session.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <gtest/gtest.h>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace tessera::test {

inline constexpr std::size_t kRamBytes = std::size_t{512} << 20, kGpuBytes = std::size_t{256} << 20;

inline const glm::ivec2 kPicture(96, 72);

/// The picture of `tessera render` of the scene as it is saved, with half of the budgets.
inline Image rendered(const Scene& scene) {
    MemoryBudget ram("RAM", "--ram", kRamBytes / 2), gpu("GPU memory", "--gpu-memory", kGpuBytes / 2);
    const StoreReader store(scene.volumes.front().path, ram);
    RenderOptions options;
    options.engine = EngineKind::native;
    options.searching = options.checking = true;
    options.verify = Verify::quick;
    return renderScene(parseScene(sceneJson(asStill(scene)), "/", "scene"), store, ram, gpu, options).image;
}

/// A session and what a window does with it.
class Looker {
  public:
    explicit Looker(bool stills = true, std::size_t ramBytes = kRamBytes,
                    const std::vector<std::string>& sets = {}) {
        ViewSessionOptions options;
        options.sets = sets;
        options.stills = stills;
        options.engine = EngineKind::native;
        options.ramBytes = ramBytes;
        options.gpuBytes = kGpuBytes;
        options.news = [this] { told(); };
        viewing = makeViewSession(options);
    }
    explicit Looker(ViewSessionOptions options) {
        options.news = [this] { told(); };
        viewing = makeViewSession(options);
    }
    ~Looker() { viewing.reset(); } // first: its thread tells news

    template <typename Condition>::testing::AssertionResult comesTo(const Condition& condition) {
        std::unique_lock lock(mutex_);
        const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(40);
        while (!condition()) {
            if (changed_.wait_until(
                    lock, std::min(end, std::chrono::steady_clock::now() + std::chrono::milliseconds(50))) ==
                    std::cv_status::timeout &&
                std::chrono::steady_clock::now() > end)
                return ::testing::AssertionFailure() << "it never came";
        }
        return ::testing::AssertionSuccess();
    }
    Scene opened(const std::filesystem::path& path) {
        viewing->open(path, kPicture);
        EXPECT_TRUE(comesTo([&] {
            const auto volume = viewing->volume();
            return volume && volume->path == path;
        }));
        return viewing->volume()->scene;
    }
    std::shared_ptr<const ShownPicture> stillOf(std::uint64_t wish) {
        EXPECT_TRUE(comesTo([&] {
            const auto picture = viewing->picture();
            return picture && picture->asked >= wish && picture->stage == Stage::still;
        }));
        return viewing->picture();
    }
    std::shared_ptr<const ShownPicture> wholeOf(std::uint64_t wish) {
        EXPECT_TRUE(comesTo([&] {
            const auto picture = viewing->picture();
            return !viewing->state().problem.empty() ||
                   (picture && picture->asked >= wish && picture->stage == Stage::whole &&
                    viewing->state().atRest);
        })) << "wish "
            << wish << ", picture of " << (viewing->picture() ? viewing->picture()->asked : 0) << ", stage "
            << (viewing->picture() ? static_cast<int>(viewing->picture()->stage) : -1) << ", at rest "
            << viewing->state().atRest << ", problem \"" << viewing->state().problem << "\"";
        EXPECT_EQ(viewing->state().problem, "");
        return viewing->picture();
    }
    std::unique_ptr<Viewing> viewing;

  private:
    void told() {
        const std::lock_guard lock(mutex_);
        changed_.notify_all();
    }
    std::mutex mutex_;
    std::condition_variable changed_;
};

} // namespace tessera::test
