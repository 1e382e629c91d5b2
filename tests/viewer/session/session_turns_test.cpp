// tests/viewer/session/session_turns_test.cpp: requests that come while a session is busy with others. None
// is lost or answered by the result of another, and one that ends while others begin discards nothing of
// theirs.
#include "tests/support/looker.h"
#include "tests/support/scene_fixture.h"

#include "core/base/program_folders.h"
#include "viewer/session/session_board.h"

#include <atomic>
#include <chrono>
#include <fstream>
#include <gtest/gtest.h>
#include <thread>

namespace tessera::test {
namespace {

using namespace std::chrono_literals;

// A request during the processing of others is handled after them: a cancelled opening is then one of those,
// never the next.
TEST(SessionBoard, NobodyHasAWishWhileOthersAreTaken) {
    SessionBoard board;
    const auto open = [](const char* path) {
        return [path](SessionWishes& wishes, SessionNews&) { wishes.toOpen = {path, {1, 1}}; };
    };
    board.ask(open("first"));
    std::atomic<bool> asked{false};
    std::thread other;
    const SessionWishes first = board.take(true, [&] {
        other = std::thread([&] {
            board.ask(open("second"));
            asked = true;
        });
        std::this_thread::sleep_for(50ms); // long enough to ask, if one could
        EXPECT_FALSE(asked);
    });
    other.join();
    ASSERT_TRUE(first.toOpen);
    EXPECT_EQ(first.toOpen->path, "first");
    const SessionWishes second = board.take(false, [] {});
    ASSERT_TRUE(second.toOpen);
    EXPECT_EQ(second.toOpen->path, "second");
    EXPECT_FALSE(board.take(false, [] {}).any());
}

// Volumes one upon the other, at all times of an opening: the last is the one that stays.
TEST(ViewSession, TheVolumeThatIsAskedForLastStays) {
    Looker looker(false);
    for (int n = 0; n < 12; ++n) {
        const auto path = storePath(n % 2 == 0 ? "sphere" : "torso");
        looker.viewing->open(path, kPicture);
        std::this_thread::sleep_for(std::chrono::milliseconds(3 * n));
    }
    ASSERT_TRUE(looker.comesTo([&] {
        const auto volume = looker.viewing->volume();
        return volume && volume->path == storePath("torso") &&
               looker.viewing->state().kind == ViewingState::Kind::open;
    }));
    EXPECT_EQ(looker.viewing->state().problem, "");
    looker.wholeOf(0);
    EXPECT_EQ(looker.viewing->volume()->path, storePath("torso"));
}

// Planes are those of the volume that is open, and end with it.
TEST(ViewSession, PlanesAreOfTheVolumeThatIsOpen) {
    Looker looker(false);
    for (const char* name : {"torso", "sphere", "torso"}) {
        looker.opened(storePath(name));
        const VolumeInfo info = looker.viewing->volume()->info;
        SliceWish wish;
        wish.placeMm = glm::dvec3(info.patientFromVoxel * glm::dvec4(glm::dvec3(info.extentVoxels) / 2.0, 1));
        wish.sizes.fill({40, 30});
        looker.viewing->showSlices(wish);
        ASSERT_TRUE(looker.comesTo([&] {
            const auto planes = looker.viewing->slices();
            return planes && !planes->planes[0].display.empty();
        })) << name;
        EXPECT_EQ(looker.viewing->slices()->planes[0].frame.pose.point, wish.placeMm) << name;
    }
}

// Nothing stays open, and a still of it is being drawn: it ends first, and reports this to a session that is
// about to let it go.
TEST(ViewSession, AStillEndsWhereNothingStaysOpen) {
    const ScratchFolder folder;
    std::ofstream(folder / "broken.json") << R"({"tesseraScene": 1, "volumes": [)";
    for (int n = 0; n < 6; ++n) {
        Looker looker;
        Scene scene = looker.opened(storePath("torso"));
        scene.imageSize = {400, 300}; // a still that takes its time
        const std::uint64_t wish = looker.viewing->show(scene, false);
        ASSERT_TRUE(looker.comesTo([&] { // all but the still, which begins now
            const auto picture = looker.viewing->picture();
            return picture && picture->asked >= wish &&
                   (picture->stage == Stage::whole || picture->stage == Stage::still);
        }));
        std::this_thread::sleep_for(std::chrono::milliseconds(20 * n));
        scene.imageSize = {4000, 4000}; // does not fit: no picture can be drawn any more
        looker.viewing->show(scene, false);
        ASSERT_TRUE(looker.comesTo([&] { return !looker.viewing->state().problem.empty(); }));
        looker.viewing->open(folder / "broken.json", kPicture);
        ASSERT_TRUE(looker.comesTo([&] {
            return looker.viewing->state().kind == ViewingState::Kind::failed;
        })) << n;
        EXPECT_EQ(looker.viewing->volume(), nullptr);
        EXPECT_EQ(looker.viewing->slices(), nullptr);
    }
}

// A line that is asked for while the one before ends: it is looked for from then on, until it is there.
TEST(ViewSession, ALineIsLookedForUntilItIsThere) {
    Looker looker(false);
    looker.opened(storePath("torso"));
    LineWish wish;
    wish.places = {{-67, -33, -155}, {0, 38, -200}}; // of the phantom's colon
    const auto comes = [&](std::uint64_t number) {
        return looker.comesTo([&] {
            const LineState line = looker.viewing->line();
            EXPECT_TRUE(line.searching || line.number == number) << "of " << number;
            return !line.searching && line.number == number;
        });
    };
    const auto start = std::chrono::steady_clock::now();
    ASSERT_TRUE(comes(looker.viewing->findLine(wish)));
    const auto whole = std::chrono::steady_clock::now() - start;
    for (int n = 0; n < 6; ++n) {
        looker.viewing->findLine(wish);
        std::this_thread::sleep_for(whole * (n + 4) / 8); // around its end
        ASSERT_TRUE(comes(looker.viewing->findLine(wish)));
        EXPECT_TRUE(looker.viewing->line().path) << looker.viewing->line().problem;
    }
}

} // namespace
} // namespace tessera::test
