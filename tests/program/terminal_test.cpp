// The output on a terminal: the line that shows the progress of a job, and the files that Ctrl-C leaves.
#include "tests/support/program_fixture.h"

#include "core/base/files.h"

#include <chrono>
#include <csignal>
#include <fcntl.h>
#include <poll.h>
#include <pty.h>

namespace tessera::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class Terminal : public Program {
  protected:
    struct Session {
        int exitCode = -1;
        std::string seen; // all that the terminal got
    };
    /// Runs the program on a terminal of its own.
    /// @param interruptAfter  what it must have said before Ctrl-C is typed; "": it is left alone
    Session onTerminal(const std::string& arguments, const std::string& interruptAfter = "") {
        int terminal = -1;
        const winsize size{24, 100, 0, 0};
        const pid_t child = ::forkpty(&terminal, nullptr, nullptr, &size);
        if (child == 0) {
            fs::current_path(folder_.path());
            ::setenv("XDG_CACHE_HOME", (folder_ / "cache").c_str(), 1);
            ::execl("/bin/sh", "sh", "-c", ("exec '" TESSERA_PROGRAM "' " + arguments).c_str(), nullptr);
            ::_exit(100);
        }
        Session session;
        char bytes[4096];
        for (;;) {
            const ssize_t got = ::read(terminal, bytes, sizeof bytes);
            if (got <= 0)
                break; // EIO: the other end is closed
            session.seen.append(bytes, static_cast<std::size_t>(got));
            if (!typed_ && !interruptAfter.empty() &&
                session.seen.find(interruptAfter) != std::string::npos) {
                typed_ = ::write(terminal, "\x03", 1) == 1; // Ctrl-C, as a keyboard sends it
                at_ = std::chrono::steady_clock::now();
            }
        }
        int status = 0;
        ::waitpid(child, &status, 0);
        ::close(terminal);
        session.exitCode = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
        secondsToEnd_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - at_).count();
        return session;
    }
    /// Starts the program on a terminal of its own and returns when it has said `word`.
    pid_t startOnTerminalUntil(const std::string& arguments, const std::string& word) {
        int terminal = -1;
        const winsize size{24, 100, 0, 0};
        const pid_t child = ::forkpty(&terminal, nullptr, nullptr, &size);
        if (child == 0) {
            fs::current_path(folder_.path());
            ::execl("/bin/sh", "sh", "-c", ("exec '" TESSERA_PROGRAM "' " + arguments).c_str(), nullptr);
            ::_exit(100);
        }
        std::string seen;
        char bytes[4096];
        for (ssize_t got = 1; got > 0 && seen.find(word) == std::string::npos;) {
            got = ::read(terminal, bytes, sizeof bytes);
            seen.append(bytes, got > 0 ? static_cast<std::size_t>(got) : 0);
        }
        terminals_.emplace_back(terminal); // open as long as the program may write to it
        return child;
    }
    /// Names in the working folder that are not the test's own.
    std::vector<std::string> leftBehind() const {
        std::vector<std::string> names;
        for (const auto& entry : fs::directory_iterator(folder_.path()))
            if (const std::string name = entry.path().filename();
                name != ".out" && name != ".err" && name != "cache")
                names.push_back(name);
        std::sort(names.begin(), names.end());
        return names;
    }

    std::vector<FileHandle> terminals_;
    bool typed_ = false;
    std::chrono::steady_clock::time_point at_;
    double secondsToEnd_ = 0;
};

TEST_F(Terminal, AStageIsNamedFromTheStartAndTheLineGoes) {
    const Session made = onTerminal("phantom torso --size 96x72x112 -o t.zarr");
    EXPECT_EQ(made.exitCode, 0);
    EXPECT_THAT(made.seen, HasSubstr("\r\033[Kimporting phantom torso"));
    EXPECT_THAT(made.seen, HasSubstr("computing statistics"));
    EXPECT_THAT(made.seen, HasSubstr("\r\033[Kwrote t.zarr"));
    const Session drawn = onTerminal("render t.zarr -o t.png --size 64x64 --gl-device software");
    EXPECT_EQ(drawn.exitCode, 0);
    for (const char* stage : {"reading statistics", "loading bricks", "choosing the step", "drawing",
                              "estimating the picture's errors", "writing the picture"})
        EXPECT_THAT(drawn.seen, HasSubstr(std::string("\r\033[K") + stage));
    EXPECT_THAT(drawn.seen, HasSubstr("\r\033[Kwrote t.png"));
    EXPECT_EQ(drawn.seen.rfind("\r\033[K"), drawn.seen.find("\r\033[Kwrote t.png")) << "a line stayed";
    EXPECT_THAT(drawn.seen, Not(HasSubstr(".first."))) << "a small volume needs no first picture";
    const Session quiet = onTerminal("render t.zarr -o t.png --size 64x64 --gl-device software --quiet");
    EXPECT_EQ(quiet.seen, "");
}

TEST_F(Terminal, NothingIsToldWhereNobodyLooks) {
    const Outcome piped = run("phantom torso --size 96x72x112 -o t.zarr");
    EXPECT_EQ(piped.problems.rfind("wrote t.zarr", 0), 0u) << piped.problems;
    EXPECT_EQ(std::count(piped.problems.begin(), piped.problems.end(), '\n'), 1);
}

// A large volume: a coarse picture comes first, beside the picture, and is gone when that is there. The
// picture is the same as without.
TEST_F(Terminal, ACoarsePictureComesFirst) {
    ASSERT_EQ(run("phantom sphere --size 300x40x40 -o s.zarr").exitCode, 0);
    const Session drawn = onTerminal("render s.zarr -o s.png --gl-device software");
    EXPECT_EQ(drawn.exitCode, 0);
    EXPECT_THAT(drawn.seen, HasSubstr("wrote s.first.png, coarse, after "));
    EXPECT_THAT(drawn.seen, HasSubstr("; the picture takes about "));
    EXPECT_EQ(leftBehind(), (std::vector<std::string>{"s.png", "s.zarr"}));
    // One that a killed program left is replaced and goes; one that was asked for stays as it is.
    const std::string first = "render s.zarr -o s.png --gl-device software";
    ASSERT_EQ(run(first + " --first s.first.png").exitCode, 0);
    const std::string asked = readAll(folder_ / "s.first.png");
    EXPECT_THAT(onTerminal(first).seen, Not(HasSubstr("s.first.png")));
    EXPECT_EQ(readAll(folder_ / "s.first.png"), asked);
    fs::remove(folder_ / "s.first.png");
    const pid_t killed = startOnTerminalUntil(first, "wrote s.first.png");
    ::kill(killed, SIGKILL);
    ::waitpid(killed, nullptr, 0);
    EXPECT_TRUE(exists("s.first.png"));
    EXPECT_THAT(onTerminal(first).seen, HasSubstr("wrote s.first.png"));
    EXPECT_EQ(leftBehind(), (std::vector<std::string>{"s.png", "s.zarr"}));
    const std::string withFirst = readAll(folder_ / "s.png");
    ASSERT_EQ(run("render s.zarr -o s.png --gl-device software").exitCode, 0);
    EXPECT_EQ(withFirst.substr(withFirst.rfind("IDAT")),
              readAll(folder_ / "s.png").substr(readAll(folder_ / "s.png").rfind("IDAT")));
}

TEST_F(Terminal, CtrlCEndsItAndLeavesNothing) {
    const Session making = onTerminal("phantom torso --size 256x256x512 -o t.zarr", "importing");
    EXPECT_TRUE(typed_);
    EXPECT_EQ(making.exitCode, 130);
    EXPECT_THAT(making.seen, HasSubstr("interrupted"));
    EXPECT_EQ(leftBehind(), std::vector<std::string>{});
    RecordProperty("secondsToEndImport", std::to_string(secondsToEnd_));

    ASSERT_EQ(run("phantom torso --size 128x96x150 -o t.zarr").exitCode, 0);
    write("t.png", "what was there before");
    typed_ = false;
    const Session drawing = onTerminal("render t.zarr -o t.png --engine reference", "drawing");
    EXPECT_TRUE(typed_);
    EXPECT_EQ(drawing.exitCode, 130);
    EXPECT_EQ(readAll(folder_ / "t.png"), "what was there before");
    EXPECT_EQ(leftBehind(), (std::vector<std::string>{"t.png", "t.zarr"}));
    RecordProperty("secondsToEndRender", std::to_string(secondsToEnd_));
}

} // namespace
} // namespace tessera::test
