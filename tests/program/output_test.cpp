// tests/program/output_test.cpp: the program's files and messages arrive, or the exit code says that they did
// not; and a good file stays good.
#include "tests/support/program_fixture.h"

#include <chrono>
#include <csignal>
#include <fcntl.h>
#include <functional>
#include <sys/resource.h>
#include <sys/stat.h>
#include <thread>

namespace tessera::test {
namespace {

using ::testing::HasSubstr;

class Output : public Program {
  protected:
    /// run() with standard output on another file.
    int runOnto(const char* out, const std::string& arguments) {
        const std::string line = "cd '" + folder_.path().string() + "' && '" TESSERA_PROGRAM "' " +
                                 arguments + " >" + out + " 2>.err";
        const int status = std::system(line.c_str());
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }
    /// The program itself, with `prepare` called in its process first.
    pid_t start(const std::vector<std::string>& words, const std::function<void()>& prepare) const {
        const pid_t child = ::fork();
        if (child != 0)
            return child;
        fs::current_path(folder_.path());
        ::setenv("XDG_CACHE_HOME", (folder_ / "cache").c_str(), 1);
        if (!std::freopen(".err", "w", stderr))
            ::_exit(100);
        prepare();
        std::vector<char*> argv;
        std::vector<std::string> copies = words;
        copies.insert(copies.begin(), "tessera");
        for (std::string& word : copies)
            argv.push_back(word.data());
        argv.push_back(nullptr);
        ::execv(TESSERA_PROGRAM, argv.data());
        ::_exit(100);
    }
    static int exitCodeOf(pid_t child) {
        int status = 0;
        ::waitpid(child, &status, 0);
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }
    std::vector<std::string> names() const {
        std::vector<std::string> all;
        for (const auto& entry : fs::directory_iterator(folder_.path()))
            if (const std::string name = entry.path().filename(); name != ".err" && name != ".out")
                all.push_back(name);
        std::sort(all.begin(), all.end());
        return all;
    }
};

TEST_F(Output, WhatCannotBePrintedIsAnError) {
    makeSphere();
    const auto expectError = [&](const std::string& arguments, const char* out) {
        EXPECT_EQ(runOnto(out, arguments), 1) << arguments << " >" << out;
        EXPECT_THAT(readAll(folder_ / ".err"), HasSubstr("tessera: standard output: cannot be written"))
            << arguments << " >" << out;
    };
    for (const char* arguments : {"info s.zarr", "--help", "--version", "cache path",
                                  "render s.zarr -q -o a.png --engine mirror --size 8x8 --json"})
        expectError(arguments, "/dev/full");
    expectError("info s.zarr --json", "&-");
    EXPECT_EQ(runOnto("&-", "render s.zarr -q -o b.png --engine mirror --size 8x8"), 0) << "prints nothing";
    EXPECT_TRUE(exists("b.png"));
}

TEST_F(Output, AFullDiskLeavesTheGoodPicture) {
    makeSphere();
    const std::vector<std::string> render = {"render",   "s.zarr", "-q",     "-o",    "a.png",
                                             "--engine", "mirror", "--size", "64x64", "--preset",
                                             "auto",     "--step", "1"};
    ASSERT_EQ(exitCodeOf(start(render, [] {})), 0);
    const std::string good = readAll(folder_ / "a.png");
    for (const rlim_t bytes : {rlim_t{0}, rlim_t{100}, rlim_t{good.size() - 1}}) {
        EXPECT_EQ(exitCodeOf(start(render,
                                   [bytes] {
                                       const rlimit limit{bytes, bytes};
                                       ::setrlimit(RLIMIT_FSIZE, &limit);
                                   })),
                  1)
            << bytes;
        EXPECT_EQ(readAll(folder_ / "a.png"), good) << bytes;
    }
    EXPECT_EQ(names(), (std::vector<std::string>{"a.png", "s.zarr"}));
}

TEST_F(Output, PicturesReplaceFilesOnly) {
    makeSphere();
    const std::string render = "render s.zarr -q --engine mirror --size 8x8 -o ";
    fs::create_directory(folder_ / "deep");
    write("deep/real.png", "old");
    fs::create_symlink("deep/real.png", folder_ / "link.png");
    EXPECT_EQ(run(render + "link.png").exitCode, 0);
    EXPECT_TRUE(fs::is_symlink(folder_ / "link.png"));
    EXPECT_EQ(readAll(folder_ / "deep/real.png").substr(1, 3), "PNG");
    ASSERT_EQ(::mkfifo((folder_ / "pipe.png").c_str(), 0600), 0);
    expectRefused(render + "pipe.png", {"pipe.png", "a pipe"});
    fs::create_symlink("/dev/null", folder_ / "null.png");
    expectRefused(render + "null.png", {"null.png", "a device"});
    expectRefused(render + "deep.png/a.png", {"an existing folder"});
    expectRefused(render + "/dev/stdout", {"/dev/stdout", ".png"});
    expectRefused(render + "/dev/null", {"/dev/null", ".png"});
    fs::create_directory(folder_ / "folder.png");
    expectRefused(render + "folder.png", {"folder.png", "a folder"});
}

TEST_F(Output, NamesCannotDriveATerminal) {
    const Outcome outcome = run("info \x1b]0;title\x07.zarr");
    EXPECT_EQ(outcome.exitCode, 2);
    EXPECT_EQ(outcome.problems.find('\x1b'), std::string::npos);
    EXPECT_THAT(outcome.problems, HasSubstr("\\x1b]0;title\\x07.zarr"));
}

// Whoever sends it: the program cleans up and says by which signal it ended.
TEST_F(Output, SignalsEndItInOrder) {
    for (const int signal : {SIGHUP, SIGINT, SIGTERM}) {
        const pid_t child = start({"phantom", "torso", "--size", "256x256x512", "-o", "t.zarr"}, [] {
            for (const int each : {SIGHUP, SIGINT, SIGTERM})
                std::signal(each, SIG_DFL);
        });
        const auto unfinished = [&] {
            return std::any_of(fs::directory_iterator(folder_.path()), {}, [](const auto& entry) {
                return entry.path().filename().string().rfind(".t.zarr.importing-", 0) == 0;
            });
        };
        for (int i = 0; i < 1000 && !unfinished(); ++i)
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        EXPECT_TRUE(unfinished());
        ::kill(child, signal);
        EXPECT_EQ(exitCodeOf(child), 128 + signal);
        EXPECT_EQ(names(), std::vector<std::string>{});
    }
}

TEST_F(Output, WhatNohupStartedOutlivesItsTerminal) {
    const pid_t child = start({"phantom", "torso", "--size", "128x96x150", "-o", "t.zarr", "-q"},
                              [] { std::signal(SIGHUP, SIG_IGN); });
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    ::kill(child, SIGHUP);
    EXPECT_EQ(exitCodeOf(child), 0);
}

// On systems that cannot exchange names, a program may die after it took the old store's name away.
TEST_F(Output, AStoreWhoseReplacementDiedIsFound) {
    makeSphere();
    fs::rename(folder_ / "s.zarr", folder_ / ".s.zarr.importing-1-0.old");
    EXPECT_EQ(run("info s.zarr").exitCode, 0);
    EXPECT_EQ(names(), std::vector<std::string>{"s.zarr"});
}

TEST_F(Output, OfTwoImportsToOneNameTheFirstStays) {
    // Both check the name before either gives it: each has to be refused when it ends, not when it begins.
    std::vector<pid_t> children;
    for (const char* size : {"96x96x96", "96x96x97", "96x96x98"})
        children.push_back(start({"phantom", "torso", "--size", size, "-o", "t.zarr", "-q"}, [] {}));
    int made = 0, refused = 0;
    for (const pid_t child : children) {
        const int code = exitCodeOf(child);
        made += code == 0;
        refused += code == 2;
    }
    EXPECT_EQ(made, 1);
    EXPECT_EQ(refused, 2);
    EXPECT_EQ(names(), std::vector<std::string>{"t.zarr"});
}

} // namespace
} // namespace tessera::test
