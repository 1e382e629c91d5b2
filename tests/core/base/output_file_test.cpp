// tests/core/base/output_file_test.cpp: a result replaces a file when it is whole and on disk, and nothing
// else; what dead processes left goes, what living ones hold stays.
#include "core/base/output_file.h"

#include "core/base/error.h"
#include "core/base/ownership.h"
#include "core/base/program_folders.h"

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <iterator>
#include <span>
#include <string>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

namespace tessera {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class OutputFiles : public ::testing::Test {
  protected:
    std::string text(const std::string& name) const {
        std::ifstream file(folder_ / name, std::ios::binary);
        return {std::istreambuf_iterator<char>(file), {}};
    }
    std::size_t names() const {
        return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_.path()), {}));
    }
    /// The message that a child process prints, or "" when body ends well.
    static std::string problemIn(const std::function<void()>& body) {
        int ends[2];
        EXPECT_EQ(::pipe(ends), 0);
        const pid_t child = ::fork();
        if (child == 0) {
            try {
                body();
            } catch (const Error& error) {
                const std::string what = error.what();
                [[maybe_unused]] const ssize_t put = ::write(ends[1], what.data(), what.size());
            }
            ::_exit(0);
        }
        ::close(ends[1]);
        std::string said(4096, '\0');
        const ssize_t got = ::read(ends[0], said.data(), said.size());
        said.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
        ::close(ends[0]);
        ::waitpid(child, nullptr, 0);
        return said;
    }
    /// Runs body in a child that is killed where it calls die().
    static void killedIn(const std::function<void()>& body) {
        const pid_t child = ::fork();
        if (child == 0) {
            body();
            ::_exit(0);
        }
        int status = 0;
        ::waitpid(child, &status, 0);
        ASSERT_TRUE(WIFSIGNALED(status));
    }
    static void die() { ::kill(::getpid(), SIGKILL); }
    void expectRefused(const std::string& name, const std::string& word) const {
        try {
            writeOutputFile(folder_ / name, "new");
            ADD_FAILURE() << name << " was written";
        } catch (const InputError& error) {
            EXPECT_THAT(error.what(), HasSubstr(name));
            EXPECT_THAT(error.what(), HasSubstr(word));
        }
    }
    const ScratchFolder folder_;
};

TEST_F(OutputFiles, AFullDiskIsToldAndTheOldFileStays) {
    writeOutputFile(folder_ / "page.md", "good");
    const std::string said = problemIn([&] {
        std::signal(SIGXFSZ, SIG_IGN);
        const rlimit limit{100, 100};
        ::setrlimit(RLIMIT_FSIZE, &limit);
        writeOutputFile(folder_ / "page.md", std::string(101, 'x'));
    });
    EXPECT_THAT(said, HasSubstr("page.md: cannot be written: "));
    EXPECT_EQ(text("page.md"), "good");
    EXPECT_EQ(names(), 1u);
}

TEST_F(OutputFiles, ALinksTargetIsReplacedNotTheLink) {
    fs::create_directory(folder_ / "deep");
    writeOutputFile(folder_ / "deep/real.md", "old");
    fs::create_symlink("deep/real.md", folder_ / "near.md");
    fs::create_symlink(folder_ / "near.md", folder_ / "far.md");
    writeOutputFile(folder_ / "far.md", "new");
    EXPECT_EQ(text("deep/real.md"), "new");
    EXPECT_TRUE(fs::is_symlink(folder_ / "near.md"));
    EXPECT_TRUE(fs::is_symlink(folder_ / "far.md"));
    fs::create_symlink("deep/none.md", folder_ / "dangling.md");
    writeOutputFile(folder_ / "dangling.md", "made");
    EXPECT_EQ(text("deep/none.md"), "made");
    fs::create_symlink("round.md", folder_ / "round.md");
    expectRefused("round.md", "nowhere");
}

TEST_F(OutputFiles, ReplacesFilesOnly) {
    fs::create_directory(folder_ / "folder.md");
    expectRefused("folder.md", "a folder");
    ASSERT_EQ(::mkfifo((folder_ / "pipe.md").c_str(), 0600), 0);
    expectRefused("pipe.md", "a pipe");
    fs::create_symlink("/dev/null", folder_ / "null.md");
    expectRefused("null.md", "a device");
    expectRefused("missing/a.md", "an existing folder");
    EXPECT_TRUE(fs::is_fifo(folder_ / "pipe.md"));
    EXPECT_EQ(names(), 3u);
    if (::geteuid() == 0)
        return; // root may write anywhere
    writeOutputFile(folder_ / "kept.md", "kept");
    fs::permissions(folder_ / "kept.md", fs::perms::owner_read);
    expectRefused("kept.md", "may be replaced");
}

TEST_F(OutputFiles, AFileThatIsKeptIsNotReplacedNorIsOneThatAppears) {
    const auto refusal = [&](const std::function<void()>& body) {
        try {
            body();
        } catch (const InputError& error) {
            return std::string(error.what());
        }
        return std::string("nothing was refused");
    };
    const std::string bytes = "new";
    {
        OutputFile file(folder_ / "a.md", Existing::isKept);
        file.writeAt(0, std::as_bytes(std::span(bytes)));
        file.finish();
    }
    EXPECT_EQ(text("a.md"), "new");
    EXPECT_THAT(refusal([&] { const OutputFile file(folder_ / "a.md", Existing::isKept); }),
                HasSubstr("a.md: expected a new name, or --force to replace, found a file"));
    EXPECT_THAT(refusal([&] {
                    OutputFile file(folder_ / "b.md", Existing::isKept);
                    file.writeAt(0, std::as_bytes(std::span(bytes)));
                    std::ofstream(folder_ / "b.md") << "theirs";
                    file.finish();
                }),
                HasSubstr("b.md: expected a new name, or --force to replace, found something"));
    EXPECT_EQ(text("b.md"), "theirs");
    EXPECT_EQ(names(), 2u);
}

TEST_F(OutputFiles, ARenameToANewNameNeedsNoSupportOfTheFileSystem) {
    for (const bool inOneStep : {true, false}) {
        std::ofstream(folder_ / "from.md") << "mine";
        std::ofstream(folder_ / "to.md") << "theirs";
        EXPECT_FALSE(renameToNewFile(folder_ / "from.md", folder_ / "to.md", inOneStep));
        EXPECT_EQ(text("from.md"), "mine");
        EXPECT_EQ(text("to.md"), "theirs");
        fs::remove(folder_ / "to.md");
        EXPECT_TRUE(renameToNewFile(folder_ / "from.md", folder_ / "to.md", inOneStep));
        EXPECT_EQ(text("to.md"), "mine");
        EXPECT_EQ(names(), 1u);
        EXPECT_THROW(renameToNewFile(folder_ / "none.md", folder_ / "other.md", inOneStep), Error);
    }
}

TEST_F(OutputFiles, KeepsThePermissionsOfWhatItReplaces) {
    writeOutputFile(folder_ / "a.md", "1");
    fs::permissions(folder_ / "a.md", fs::perms::owner_read | fs::perms::owner_write);
    writeOutputFile(folder_ / "a.md", "2");
    EXPECT_EQ(fs::status(folder_ / "a.md").permissions(), fs::perms::owner_read | fs::perms::owner_write);
    EXPECT_EQ(text("a.md"), "2");
}

TEST_F(OutputFiles, WhatDeadProcessesLeftGoesAndWhatLivingOnesHoldStays) {
    killedIn([&] {
        const OutputFile left(folder_ / "a.md");
        die();
    });
    EXPECT_EQ(names(), 1u);
    const OutputFile living(folder_ / "b.md");
    writeOutputFile(folder_ / ".a.md.tessera-old", "a name that is no temporary one");
    writeOutputFile(folder_ / "c.md", "text");
    EXPECT_EQ(names(), 3u) << "the dead one's is gone";
    EXPECT_TRUE(fs::exists(living.path()));
    EXPECT_TRUE(fs::exists(folder_ / ".a.md.tessera-old"));
}

TEST_F(OutputFiles, ScratchFoldersOfTheDeadGo) {
    const char* const given = std::getenv("TMPDIR");
    const std::string before = given ? given : "";
    ::setenv("TMPDIR", folder_.path().c_str(), 1);
    killedIn([&] {
        const ScratchFolder left;
        std::ofstream(left / "slice") << "data";
        die();
    });
    EXPECT_EQ(names(), 1u);
    fs::create_directory(folder_ / "tessera-notes");
    {
        const ScratchFolder first, second; // each other's are left alone
        EXPECT_EQ(names(), 3u);
        EXPECT_TRUE(fs::exists(first.path()));
    }
    EXPECT_EQ(names(), 1u) << "what is not ours stays";
    given ? ::setenv("TMPDIR", before.c_str(), 1) : ::unsetenv("TMPDIR");
}

TEST_F(OutputFiles, NamesOfTemporaryFiles) {
    const std::string name = temporaryName("a.b.png", "tessera", 7);
    EXPECT_EQ(nameOfTemporary(name, "tessera"), "a.b.png");
    EXPECT_EQ(nameOfTemporary(name + "-removed", "tessera"), "a.b.png");
    for (const char* foreign : {"", ".", "a.tessera-1-2", ".tessera-1-2", ".a.tessera-1", ".a.tessera-1-",
                                ".a.tessera-1-x", ".a.tessera--2", ".a.importing-1-2"})
        EXPECT_FALSE(nameOfTemporary(foreign, "tessera")) << foreign;
    const std::string tooLong = std::string(250, 'n') + ".zarr";
    const std::string shortened = temporaryName(tooLong, "importing", 1000);
    EXPECT_LE(shortened.size(), 255u);
    EXPECT_TRUE(nameOfTemporary(shortened, "importing")->ends_with(".zarr"));
}

} // namespace
} // namespace tessera
