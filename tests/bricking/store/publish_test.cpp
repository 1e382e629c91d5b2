// tests/bricking/store/publish_test.cpp: giving a store its final name: nothing is replaced unasked, and a
// process that is killed leaves the old store or the new one.
#include "bricking/store/store_files.h"
#include "bricking/store/work_folder.h"
#include "core/base/error.h"
#include "core/base/ownership.h"
#include "core/base/program_folders.h"
#include "tests/support/bricking_store_tools.h"

#include <cerrno>
#include <csignal>
#include <fcntl.h> // AT_FDCWD
#include <fstream>
#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <iterator>
#include <string>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

namespace {
int renamesRefuse = 0; // error of a rename with flags; 0: they work
int killIn = 0;        // this many steps; 0: never. A step is before a rename or behind one

void maybeKill() {
    if (killIn > 0 && --killIn == 0)
        ::kill(::getpid(), SIGKILL);
}
std::string order; // of what gives a store its name: s(ync of a file system), r(ename), f(sync of a folder)
} // namespace

// In place of the C library's, in this program. No test waits for a disk.
extern "C" int syncfs(int) noexcept {
    order += 's';
    return 0;
}
extern "C" int fsync(int) {
    order += 'f';
    return 0;
}
/// As on file systems that cannot exchange names.
extern "C" int renameat2(int fromFolder, const char* from, int toFolder, const char* to, unsigned flags) {
    order += 'r';
    if (renamesRefuse != 0 && flags != 0) {
        errno = renamesRefuse;
        return -1;
    }
    maybeKill();
    const auto result = static_cast<int>(::syscall(SYS_renameat2, fromFolder, from, toFolder, to, flags));
    maybeKill();
    return result;
}
extern "C" int rename(const char* from, const char* to) noexcept {
    maybeKill();
    const auto result = static_cast<int>(::syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0));
    maybeKill();
    return result;
}

namespace tessera {
namespace {

namespace fs = std::filesystem;

class Publishing : public ::testing::Test {
  protected:
    /// A folder with one file that says which it is.
    fs::path make(const std::string& name, const std::string& text) const {
        fs::create_directory(folder_ / name);
        std::ofstream(folder_ / name / "zarr.json") << text;
        return folder_ / name;
    }
    std::string text(const std::string& name) const {
        std::ifstream file(folder_ / name / "zarr.json");
        return {std::istreambuf_iterator<char>(file), {}};
    }
    std::vector<std::string> names() const {
        std::vector<std::string> all;
        for (const auto& entry : fs::directory_iterator(folder_.path()))
            all.push_back(entry.path().filename());
        return all;
    }
    static void killedIn(const std::function<void()>& body) {
        const pid_t child = ::fork();
        if (child == 0) {
            body();
            ::kill(::getpid(), SIGKILL);
        }
        int status = 0;
        ::waitpid(child, &status, 0);
        ASSERT_TRUE(WIFSIGNALED(status));
    }
    const ScratchFolder folder_;
};

TEST_F(Publishing, WhatAppearedMeanwhileIsNotReplacedUnasked) {
    TemporaryFolder mine(folder_ / "a.zarr");
    std::ofstream(mine.path() / "zarr.json") << "mine";
    {
        TemporaryFolder theirs(folder_ / "a.zarr"); // a second import, which ends first
        std::ofstream(theirs.path() / "zarr.json") << "theirs";
        theirs.commit(false, false);
    }
    EXPECT_THROW(mine.commit(false, false), InputError);
    EXPECT_EQ(text("a.zarr"), "theirs");
    mine.commit(false, true);
    EXPECT_EQ(text("a.zarr"), "mine");
    EXPECT_EQ(names(), std::vector<std::string>{"a.zarr"});
}

/// A crash leaves no name without the data; where that does not matter, nothing waits for a disk.
TEST_F(Publishing, DataAreOnTheDiskBeforeTheName) {
    for (const bool isDurable : {true, false}) {
        test::HashSource source(test::plainInfo({4, 3, 2}, ValueType::u8));
        order.clear();
        test::import(folder_ / (isDurable ? "a.zarr" : "b.zarr"), source, false, 2, test::kPlenty, isDurable);
        EXPECT_EQ(order, isDurable ? "srf" : "r");
    }
    EXPECT_TRUE(ImportOptions().durable);
}

TEST_F(Publishing, ReplacesWithAndWithoutExchange) {
    for (const bool exchanges : {true, false}) {
        make("a.zarr", "old");
        publishFolder(make("new", "new"), folder_ / "a.zarr", true, exchanges);
        EXPECT_EQ(text("a.zarr"), "new");
        EXPECT_EQ(names(), std::vector<std::string>{"a.zarr"});
        EXPECT_THROW(publishFolder(make("new", "newer"), folder_ / "a.zarr", false, exchanges), InputError);
        EXPECT_EQ(text("a.zarr"), "new");
        fs::remove_all(folder_ / "new");
        fs::remove_all(folder_ / "a.zarr");
        publishFolder(make("new", "first"), folder_ / "a.zarr", false, exchanges);
        EXPECT_EQ(text("a.zarr"), "first");
    }
}

TEST_F(Publishing, ReplacesWhereTheFileSystemKnowsNoExchange) {
    for (const int error : {EINVAL, ENOSYS, ENOTSUP}) {
        make("a.zarr", "old");
        renamesRefuse = error;
        EXPECT_NO_THROW(publishFolder(make("new", "new"), folder_ / "a.zarr", true)) << error;
        EXPECT_EQ(text("a.zarr"), "new");
        EXPECT_EQ(names(), std::vector<std::string>{"a.zarr"});
        EXPECT_THROW(publishFolder(make("new", "newer"), folder_ / "a.zarr", false), InputError);
        EXPECT_EQ(text("a.zarr"), "new");
        fs::remove_all(folder_ / "a.zarr");
        EXPECT_NO_THROW(publishFolder(folder_ / "new", folder_ / "a.zarr", false)) << error;
        EXPECT_EQ(text("a.zarr"), "newer");
        renamesRefuse = 0;
        fs::remove_all(folder_ / "a.zarr");
    }
}

TEST_F(Publishing, AFileOfThatNameIsNotReplaced) {
    std::ofstream(folder_ / "a.zarr") << "notes";
    EXPECT_THROW(publishFolder(make("new", "new"), folder_ / "a.zarr", false), InputError);
    EXPECT_TRUE(fs::is_regular_file(folder_ / "a.zarr"));
}

// On systems that cannot exchange names there are two renames; a process may die between them.
TEST_F(Publishing, AnOldStoreGetsItsNameBackFromADeadProcess) {
    const fs::path half = folder_ / temporaryName("a.zarr", "importing", 0);
    killedIn([&] {
        make(half.filename(), "new");
        make(half.filename().string() + ".old", "old");
    });
    recoverFolders(folder_.path());
    EXPECT_EQ(text("a.zarr"), "old");
    EXPECT_EQ(names(), std::vector<std::string>{"a.zarr"});
    killedIn([&] { make(half.filename().string() + ".old", "older"); }); // died before it was removed
    recoverFolders(folder_.path());
    EXPECT_EQ(text("a.zarr"), "old");
    EXPECT_EQ(names(), std::vector<std::string>{"a.zarr"});
}

// An import that can be continued, and replaces a store: whenever it dies, one of both stores has the name,
// and the new one has it or can still be published.
TEST_F(Publishing, AKillWhileAStoreIsReplacedLosesNothing) {
    const std::string key(32, 'a');
    const auto import = [&](const std::function<void(WorkFolder&)>& before) {
        WorkFolder work(folder_ / "a.zarr", {key, false});
        before(work);
        work.publish(false, true);
    };
    for (const int error : {0, EINVAL}) {
        bool wasOld = false, wasNew = false;
        for (int moment = 1;; ++moment) {
            SCOPED_TRACE(std::to_string(error) + ", " + std::to_string(moment));
            ASSERT_LT(moment, 20);
            make("a.zarr", "old");
            const pid_t child = ::fork();
            if (child == 0) {
                import([&](WorkFolder& work) {
                    std::ofstream(work.store() / "zarr.json") << "new";
                work.makePart(0, [](const fs::path&) {});
                renamesRefuse = error;
                killIn = moment;
            });
            ::_exit(0);
        }
        int status = 0;
        ::waitpid(child, &status, 0);
        if (!WIFSIGNALED(status)) {
            EXPECT_GT(moment, error == 0 ? 2 : 4);
            EXPECT_EQ(text("a.zarr"), "new");
            break;
        }
        recoverFolders(folder_.path());
        if (text("a.zarr") == "old") {
            wasOld = true;
            EXPECT_EQ(WorkFolder::partsOf(folder_ / "a.zarr", key), 1);
                import([](const WorkFolder& work) {
                    EXPECT_TRUE(fs::exists(work.part(0)));
                EXPECT_FALSE(work.isFinished());
        });
    }
    else {
        wasNew = true;
    }
    EXPECT_EQ(text("a.zarr"), "new");
    EXPECT_EQ(names(), std::vector<std::string>{"a.zarr"});
    fs::remove_all(folder_ / "a.zarr");
}
EXPECT_TRUE(wasOld&& wasNew) << error;
fs::remove_all(folder_ / "a.zarr");
} // namespace
} // namespace tessera

TEST_F(Publishing, ADeadImportIsSweptALivingOneIsNot) {
    killedIn([&] {
        const TemporaryFolder left(folder_ / "a.zarr");
        std::ofstream(left.path() / "zarr.json") << "half";
        ::kill(::getpid(), SIGKILL);
    });
    EXPECT_EQ(names().size(), 1u);
    const TemporaryFolder living(folder_ / "b.zarr");
    fs::create_directory(folder_ / ".a.importing-1-2"); // no store's
    const TemporaryFolder next(folder_ / "c.zarr");
    EXPECT_TRUE(fs::exists(living.path()));
    EXPECT_TRUE(fs::exists(next.path()));
    EXPECT_TRUE(fs::exists(folder_ / ".a.importing-1-2"));
    EXPECT_EQ(names().size(), 3u);
}

TEST_F(Publishing, ALinkToAStoreStaysALink) {
    fs::create_directory(folder_ / "disk");
    make("disk/real.zarr", "old");
    fs::create_directory_symlink("disk/real.zarr", folder_ / "a.zarr");
    TemporaryFolder made(folder_ / "a.zarr");
    std::ofstream(made.path() / "zarr.json") << "new";
    made.commit(false, true);
    EXPECT_TRUE(fs::is_symlink(folder_ / "a.zarr"));
    EXPECT_EQ(text("disk/real.zarr"), "new");
}

} // namespace
} // namespace tessera
