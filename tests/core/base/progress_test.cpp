// tests/core/base/progress_test.cpp: the progress line of a long job on a terminal: the share done, which
// never goes back, and the time for the rest.
#include "core/base/progress.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <string>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

namespace tessera {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

using namespace std::chrono_literals;

/// What a terminal gets to see of a job in another process: f(progress).
template <typename Job> std::string seenOnTerminal(const Job& job) {
    int terminal = -1;
    const winsize size{24, 100, 0, 0};
    const pid_t child = ::forkpty(&terminal, nullptr, nullptr, &size);
    if (child == 0) {
        Progress progress(Verbosity::normal);
        job(progress);
        progress.end();
        ::_exit(0);
    }
    std::string seen;
    char bytes[256];
    for (ssize_t got = 1; got > 0;) {
        got = ::read(terminal, bytes, sizeof bytes);
        seen.append(bytes, got > 0 ? static_cast<std::size_t>(got) : 0);
    }
    ::waitpid(child, nullptr, 0);
    ::close(terminal);
    return seen;
}

TEST(Progress, TellsTheTimeOfTheRestAndNeverGoesBack) {
    const std::string seen = seenOnTerminal([](Progress& progress) {
        progress.stage("counting");
        std::this_thread::sleep_for(550ms); // half a second passes before the rest is judged
        progress.update(0.5);
        std::this_thread::sleep_for(110ms); // a line is drawn ten times a second at most
        progress.update(0.25);              // of a thread that comes late
        progress.stage("reading");
        std::this_thread::sleep_for(550ms);
        progress.update(0.0045);
    });
    EXPECT_THAT(seen, HasSubstr("counting ..."));
    EXPECT_THAT(seen, HasSubstr("counting: 50 %, 1 s left")); // as long again as the half that is done
    EXPECT_THAT(seen, Not(HasSubstr("25 %")));
    // 0.45 % in half a second: two minutes are left, more on a machine that is late.
    EXPECT_THAT(seen, ContainsRegex("reading: 0 %, [0-9]+ min [0-5][0-9] s left"));
    EXPECT_THAT(seen, testing::EndsWith("\r\033[K"));
}

/// What an earlier run did is done at once, and says nothing about the rest; a stage can say more of itself.
TEST(Progress, TellsMoreOfAStageThatGoesOn) {
    const std::string seen = seenOnTerminal([](Progress& progress) {
        progress.stage("drawing");
        progress.startAt(0.8);
        progress.detail(", 4 rounds, noise 0.031");
        std::this_thread::sleep_for(1100ms);
        progress.update(0.9); // half of what was left
        progress.stage("reading");
    });
    EXPECT_THAT(seen, HasSubstr("drawing, 4 rounds, noise 0.031: 80 %\r"));
    EXPECT_THAT(seen, ContainsRegex("drawing, 4 rounds, noise 0.031: 90 %, [23] s left"));
    EXPECT_THAT(seen, HasSubstr("reading ..."));
}

TEST(Progress, AStageBeginsAtNothingAndNeverGoesBack) {
    Progress progress(Verbosity::quiet, true);
    EXPECT_EQ(progress.now().what, "");
    for (const char* what : {"counting", "reading"}) {
        progress.stage(what);
        EXPECT_EQ(progress.now().what, what);
        EXPECT_EQ(progress.now().share, 0);
        for (const auto& [told, share] : {std::pair{0.25, 0.25}, {0.75, 0.75}, {0.5, 0.75}, {2.0, 1.0}}) {
            progress.update(told);
            EXPECT_EQ(progress.now().share, share) << what << ", " << told;
        }
    }
}

} // namespace
} // namespace tessera
