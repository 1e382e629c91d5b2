// tests/viewer/session/paths_session_test.cpp: scenes whose light follows paths. In motion they are lit
// without paths; at rest rounds of samples come one after the other, up to the very picture of the program. A
// change ends them at once, and leaves nothing of them.
#include "bricking/store/store_reader.h"
#include "core/base/program_folders.h"
#include "core/scene/preset.h"
#include "core/scene/scene_presets.h"
#include "render/picture/render_scene.h"
#include "tests/support/looker.h"
#include "tests/support/scene_fixture.h"
#include "viewer/session/view_geometry.h"

#include <atomic>
#include <chrono>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <iterator>
#include <thread>

namespace tessera::test {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using Clock = std::chrono::steady_clock;

Scene withPaths(Scene scene, int samples = PixelSampling::kAutomatic) {
    applyLook("cinematic", scene);
    scene.quality.pixels.samples = samples;
    return scene;
}

/// All pictures of a scene until its still is there.
std::vector<std::shared_ptr<const ShownPicture>> picturesUntilStill(Looker& looker, std::uint64_t wish) {
    std::vector<std::shared_ptr<const ShownPicture>> pictures;
    EXPECT_TRUE(looker.comesTo([&] {
        const auto picture = looker.viewing->picture();
        if (picture && picture->asked >= wish && (pictures.empty() || picture != pictures.back()))
            pictures.push_back(picture);
        const ViewingState state = looker.viewing->state();
        EXPECT_LE(state.ramUsed, kRamBytes);
        EXPECT_LE(state.gpuUsed, kGpuBytes);
        return !pictures.empty() && pictures.back()->stage == Stage::still;
    })) << looker.viewing->state().problem;
    return pictures;
}

bool roundComes(Looker& looker, std::uint64_t wish) {
    return static_cast<bool>(looker.comesTo([&] {
        const auto picture = looker.viewing->picture();
        return picture && picture->asked >= wish && picture->stage == Stage::round;
    }));
}

TEST(PathsSession, RoundsComeInOrderAndEndInTheStill) {
    Looker looker;
    const Scene off = looker.opened(storePath("torso"));
    const Image before = looker.stillOf(0)->image;
    Scene scene = withPaths(off);
    scene.imageSize = {112, 84}; // rounds that take their time
    const std::uint64_t wish = looker.viewing->show(scene, false);
    const auto pictures = picturesUntilStill(looker, wish);
    std::vector<std::shared_ptr<const ShownPicture>> rounds;
    for (const auto& picture : pictures) {
        EXPECT_EQ(picture->displaySize, scene.imageSize);
        if (picture->stage != Stage::round) {
            EXPECT_TRUE(rounds.empty() || picture == pictures.back()) << "a picture without paths among them";
            continue;
        }
        EXPECT_EQ(picture->image.size, scene.imageSize);
        EXPECT_EQ(picture->camera, std::get<Camera>(scene.camera));
        EXPECT_EQ(picture->manifest, "");
        ASSERT_TRUE(picture->samples);
        EXPECT_EQ(picture->samples->asked, Transport::kSamples);
        if (!rounds.empty()) {
            EXPECT_GT(picture->samples->taken, rounds.back()->samples->taken);
            EXPECT_LT(*picture->samples->noise, rounds.back()->samples->noise.value_or(1));
        }
        EXPECT_EQ(picture->samples->noise.has_value(), picture->samples->taken > 1);
        rounds.push_back(picture);
    }
    ASSERT_GE(rounds.size(), 4u) << "of the six that there are";
    EXPECT_LE(rounds.front()->samples->taken, 2);
    const auto& still = pictures.back();
    ASSERT_TRUE(still->samples);
    EXPECT_EQ(still->samples->taken, Transport::kSamples);
    EXPECT_LT(*still->samples->noise, *rounds.back()->samples->noise);
    EXPECT_THAT(still->manifest, HasSubstr("transport"));
    EXPECT_TRUE(bitEqual(still->image, rendered(scene)));
    EXPECT_TRUE(looker.comesTo([&] { return looker.viewing->state().atRest; }));

    // Switched off again, as if there had been none.
    const auto plain = picturesUntilStill(looker, looker.viewing->show(off, false));
    for (const auto& picture : plain)
        EXPECT_FALSE(picture->samples);
    EXPECT_TRUE(bitEqual(plain.back()->image, rendered(off)));
    EXPECT_TRUE(bitEqual(plain.back()->image, before)) << "switching paths on left something";
}

TEST(PathsSession, InMotionItIsLitWithoutPaths) {
    Looker paths(false), plain(false);
    Scene scene = withPaths(paths.opened(storePath("torso")));
    plain.opened(storePath("torso"));
    Scene without = scene;
    without.lighting.transport.reset();
    without.lighting.environment.reset();
    const auto lit = paths.wholeOf(paths.viewing->show(scene, false));
    EXPECT_FALSE(isBlank(lit->image));
    EXPECT_FALSE(lit->samples);
    EXPECT_TRUE(bitEqual(lit->image, plain.wholeOf(plain.viewing->show(without, false))->image));
    EXPECT_EQ(paths.viewing->state().firstAlone, "");
}

// A change amid rounds: pictures of the change come while the still ends, and no round of the scene before.
TEST(PathsSession, AChangeEndsThem) {
    constexpr int kVeryMany = 4096; // samples: minutes
    Looker looker, fresh;
    Scene scene = withPaths(looker.opened(storePath("torso")), 16);
    fresh.opened(storePath("torso"));
    const auto first = looker.stillOf(looker.viewing->show(scene, false));
    const Scene before = scene;
    Scene slow = withPaths(scene, kVeryMany);
    slow.imageSize = {200, 160};
    ASSERT_TRUE(roundComes(looker, looker.viewing->show(slow, false)));

    // The camera turns: pictures in motion, then rounds of the new view.
    for (int n = 0; n < 3; ++n) {
        slow.camera = orbited(std::get<Camera>(slow.camera), {0.2, 0.1});
        const std::uint64_t wish = looker.viewing->show(slow, true);
        const auto asked = Clock::now();
        ASSERT_TRUE(looker.comesTo([&] { return looker.viewing->picture()->asked >= wish; }));
        const auto picture = looker.viewing->picture();
        EXPECT_LT(Clock::now() - asked, 3s);
        EXPECT_EQ(picture->stage, Stage::moving);
        EXPECT_FALSE(picture->samples) << "a round of the view before";
        EXPECT_EQ(picture->camera, std::get<Camera>(slow.camera));
        std::this_thread::sleep_for(30ms);
        EXPECT_EQ(looker.viewing->picture()->stage, Stage::moving) << "a round of the view before";
        if (n == 1) {
            ASSERT_TRUE(roundComes(looker, looker.viewing->show(slow, false)));
        }
    }
    ASSERT_TRUE(roundComes(looker, looker.viewing->show(slow, false)));
    EXPECT_EQ(looker.viewing->picture()->camera, std::get<Camera>(slow.camera));

    // Function, cuts and size change: the picture of a session that has seen nothing else.
    scene = slow;
    scene.quality.pixels.samples = 8;
    scene.imageSize = {72, 60};
    scene.volumes.front().transferFunction = presetFunction("soft-tissue", looker.viewing->volume()->values);
    scene.cuts.boxes = {{glm::dvec3(0), 0.6 * glm::dvec3(looker.viewing->volume()->info.extentVoxels),
                         CropBox::Space::voxels, Keep::inside}};
    const auto changed = looker.stillOf(looker.viewing->show(scene, false));
    EXPECT_TRUE(bitEqual(changed->image, fresh.stillOf(fresh.viewing->show(scene, false))->image));
    EXPECT_TRUE(bitEqual(changed->image, rendered(scene)));
    // And back, as undo does.
    EXPECT_TRUE(bitEqual(looker.stillOf(looker.viewing->show(before, false))->image, first->image));
}

// A round and a change that wait for the session together: the round is of the scene before, and not shown.
TEST(PathsSession, NoRoundComesAfterAChange) {
    std::atomic<bool> holds{false}, held{false};
    ViewSessionOptions options;
    options.engine = EngineKind::native;
    options.ramBytes = kRamBytes;
    options.gpuBytes = kGpuBytes;
    options.news = [&] { // on the session's thread
        for (held = holds.load(); holds;)
            std::this_thread::yield();
    };
    const auto viewing = makeViewSession(options);
    const auto waits = [](const auto& condition) {
        const auto end = Clock::now() + 40s;
        while (!condition() && Clock::now() < end)
            std::this_thread::yield(); // to see pictures that are there for an instant
        return condition();
    };
    viewing->open(storePath("torso"), {24, 20}); // many rounds in a short time
    ASSERT_TRUE(waits([&] { return viewing->volume() != nullptr; }));
    Scene scene = withPaths(viewing->volume()->scene, PixelSampling::kMost);
    std::uint64_t wish = viewing->show(scene, false);
    ASSERT_TRUE(waits([&] {
        return viewing->picture() && viewing->picture()->asked >= wish &&
               viewing->picture()->stage == Stage::round;
    }));
    holds = true;
    ASSERT_TRUE(waits([&] { return held.load(); })) << "no further round";
    std::this_thread::sleep_for(300ms); // of which some come
    scene.camera = orbited(std::get<Camera>(scene.camera), {0.3, 0.1});
    wish = viewing->show(scene, true);
    holds = false;
    ASSERT_TRUE(waits([&] { return viewing->picture()->asked >= wish; }));
    EXPECT_EQ(viewing->picture()->stage, Stage::moving);
}

// The same request again, as a window sends it when it comes to rest, does not begin anew.
TEST(PathsSession, TheSameSceneAgainGoesOn) {
    Looker looker;
    Scene scene = withPaths(looker.opened(storePath("torso")));
    scene.imageSize = {160, 120};
    ASSERT_TRUE(roundComes(looker, looker.viewing->show(scene, false)));
    const std::uint64_t again = looker.viewing->show(scene, false);
    const auto pictures = picturesUntilStill(looker, again);
    int last = 0;
    for (const auto& picture : pictures) {
        ASSERT_TRUE(picture->samples) << "it began anew";
        EXPECT_GE(picture->samples->taken, last);
        last = picture->samples->taken;
    }
    EXPECT_EQ(last, Transport::kSamples);
}

TEST(PathsSession, SavesWhatIsShownAndASceneThatDrawsIt) {
    const ScratchFolder folder;
    Looker looker;
    Scene scene = withPaths(looker.opened(storePath("torso")), 4096);
    scene.imageSize = {160, 120};
    ASSERT_TRUE(roundComes(looker, looker.viewing->show(scene, false)));
    looker.viewing->saveScreenshot(folder / "round.png", {});
    const auto manifestOf = [](const std::filesystem::path& file) {
        std::ifstream stream(file, std::ios::binary);
        return std::string(std::istreambuf_iterator<char>(stream), {});
    };
    EXPECT_THAT(manifestOf(folder / "round.png"), HasSubstr(R"("coarse":true)"));
    EXPECT_THAT(manifestOf(folder / "round.png"), HasSubstr(R"("samples":)"));

    // A still of another size, for a file: no rounds of it are shown.
    Scene saved = withPaths(scene);
    saved.imageSize = {40, 32};
    looker.viewing->saveStill(saved, folder / "saved.png", {});
    EXPECT_TRUE(looker.comesTo([&] {
        EXPECT_NE(looker.viewing->picture()->image.size, saved.imageSize);
        return !looker.viewing->takeNotice().empty() || !looker.viewing->state().problem.empty();
    }));
    EXPECT_EQ(looker.viewing->state().problem, "");
    EXPECT_THAT(manifestOf(folder / "saved.png"), HasSubstr("transport"));

    EXPECT_EQ(asStill(saved).quality.pixels.samples, Transport::kSamples);
    Scene other = saved;
    other.mode = Mode::maximum; // has no light
    EXPECT_EQ(asStill(other).quality.pixels.samples, PixelSampling::kAutomatic);
    other = saved;
    other.quality.pixels.noise = 0.01;
    EXPECT_EQ(asStill(other).quality.pixels.samples, PixelSampling::kMostForNoise);
    other = saved;
    other.lighting = {};
    EXPECT_EQ(asStill(other).quality.pixels.samples, PixelSampling::kAutomatic);
}

TEST(PathsSession, SaysWhatPathsDoNotDraw) {
    Looker looker;
    Scene scene = withPaths(looker.opened(storePath("torso")));
    scene.surfaces = {{300}};
    scene.lighting.transport = Transport{TransportResponse::contract};
    scene.lighting.environment.reset();
    looker.viewing->show(scene, false);
    ASSERT_TRUE(looker.comesTo([&] { return !looker.viewing->state().problem.empty(); }));
    EXPECT_THAT(looker.viewing->state().problem,
                HasSubstr("lighting.transport: expected no isosurfaces beside response \"contract\""));
    ASSERT_TRUE(looker.viewing->picture());
    EXPECT_FALSE(isBlank(looker.viewing->picture()->image)) << "the picture without paths stays";
    EXPECT_TRUE(looker.comesTo([&] { return looker.viewing->state().atRest; }));
}

// An engine that was asked for and follows no paths: its pictures in motion are there, and stills say why
// not.
TEST(PathsSession, AnEngineWithoutPathsShowsTheLights) {
    ViewSessionOptions options;
    options.engine = EngineKind::gpu;
    options.device.text = "software";
    options.ramBytes = kRamBytes;
    options.gpuBytes = kGpuBytes;
    options.sets = {"lighting.transport.bounces=3"};
    Looker looker(options);
    EXPECT_TRUE(looker.opened(storePath("torso")).lighting.transport);
    ASSERT_TRUE(looker.comesTo([&] { return !looker.viewing->state().problem.empty(); }));
    EXPECT_THAT(looker.viewing->state().problem, HasSubstr("it follows no paths of light"));
    ASSERT_TRUE(looker.viewing->picture());
    EXPECT_FALSE(isBlank(looker.viewing->picture()->image));
}

} // namespace
} // namespace tessera::test
