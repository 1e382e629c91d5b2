// tests/bricking/import/resume_test.cpp: imports that are killed at every write and at random moments, and
// imports that several processes share: the next one goes on, and the bytes are those of one run.
#include "bricking/import/importer.h"
#include "bricking/store/store_files.h"
#include "bricking/store/store_writer.h"
#include "bricking/store/work_folder.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "tests/support/bricking_store_tools.h"

#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <fcntl.h> // AT_FDCWD
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <random>
#include <string>
#include <sys/syscall.h>
#include <sys/vfs.h> // statfs
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

namespace {
/// Kills of processes lose nothing of a file system, and one in memory is many times as fast.
const bool isInMemory = ::access("/dev/shm", W_OK) == 0 && ::setenv("TMPDIR", "/dev/shm", 1) == 0;
bool hasLocks = true;
/// Changes of files that this process still makes; at the next one it is killed, in the middle of a write.
int changesLeft = -1; // negative: never
std::string order;    // of s(yncs of a file system) and names of p(arts)
bool isLast() {
    return changesLeft >= 0 && changesLeft-- == 0;
}
[[noreturn]] void die() {
    ::kill(::getpid(), SIGKILL);
    for (;;)
        ::pause();
}
} // namespace

// In place of the C library's, in this program.
extern "C" ssize_t pwrite(int file, const void* bytes, std::size_t count, off_t offset) {
    if (isLast()) {
        ::syscall(SYS_pwrite64, file, bytes, count / 2, offset);
        die();
    }
    return ::syscall(SYS_pwrite64, file, bytes, count, offset);
}
extern "C" int rename(const char* from, const char* to) noexcept {
    if (isLast())
        die();
    if (std::string(from).find(".making-") != std::string::npos)
        order += 'p';
    return static_cast<int>(::syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0));
}
extern "C" int renameat2(int fromFolder, const char* from, int toFolder, const char* to,
                         unsigned flags) noexcept {
    if (isLast())
        die();
    return static_cast<int>(::syscall(SYS_renameat2, fromFolder, from, toFolder, to, flags));
}
extern "C" int mkdir(const char* path, mode_t mode) noexcept {
    if (isLast())
        die();
    return static_cast<int>(::syscall(SYS_mkdirat, AT_FDCWD, path, mode));
}
extern "C" int unlinkat(int folder, const char* path, int flags) noexcept {
    if (isLast())
        die();
    return static_cast<int>(::syscall(SYS_unlinkat, folder, path, flags));
}
// As on a file system that other machines share, without locks.
extern "C" int flock(int file, int operation) noexcept {
    if (hasLocks)
        return static_cast<int>(::syscall(SYS_flock, file, operation));
    errno = EOPNOTSUPP;
    return -1;
}
extern "C" int statfs(const char* path, struct statfs* facts) noexcept {
    constexpr int kNfs = 0x6969;
    const auto result = static_cast<int>(::syscall(SYS_statfs, path, facts));
    if (!hasLocks)
        facts->f_type = kNfs;
    return result;
}
extern "C" int syncfs(int) noexcept { // no test waits for a disk
    order += 's';
    return 0;
}

namespace tessera {
namespace {

using namespace test;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;
using Files = std::map<std::string, std::string>;

const std::string kKey = "0123456789abcdef0123456789abcdef", kOther = "ffff456789abcdef0123456789abcdef";

Files filesIn(const fs::path& folder) {
    Files files;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
        if (entry.is_regular_file())
            files[entry.path().lexically_relative(folder)] = fileText(entry.path());
    return files;
}

/// A slice costs some time, as that of a file does.
class SlowSource final : public HashSource {
  public:
    using HashSource::HashSource;
    void readSlices(int count, std::span<std::byte> out) override {
        if (microseconds > 0)
            ::usleep(static_cast<useconds_t>(microseconds * count));
        if ((nextZ += count) > errorAtZ)
            throw Error("test: the disk fails");
        HashSource::readSlices(count, out);
    }
    int microseconds = 0, nextZ = 0, errorAtZ = INT32_MAX;
};

class Resume : public ::testing::Test {
  protected:
    ImportOptions options() const {
        ImportOptions made;
        made.threads = 1;
        made.key = kKey;
        made.partSlices = partSlices_;
        made.codec = codec_;
        made.reopen = [this] { return source(); };
        return made;
    }
    std::unique_ptr<SlabSource> source() const {
        auto made = std::make_unique<SlowSource>(info_, values_);
        made->microseconds = sliceMicroseconds_;
        return made;
    }
    ImportReport import(const std::string& name, const ImportOptions& options) const {
        MemoryBudget ram("RAM", "--ram", kPlenty);
        return importToStore(*source(), scratch_ / name, ram, options);
    }
    /// In a child that is killed at a change of files.
    /// @return true: it was
    bool killedAt(int change, const ImportOptions& how) const {
        const pid_t child = ::fork();
        if (child == 0) {
            changesLeft = change;
            import("v.zarr", how);
            ::_exit(0);
        }
        return ended(child) != 0;
    }
    /// The exit code, or -1 of a kill.
    static int ended(pid_t child) {
        int status = 0;
        ::waitpid(child, &status, 0);
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }
    pid_t started(const ImportOptions& how) const {
        const pid_t child = ::fork();
        if (child == 0) {
            try {
                import("v.zarr", how);
                ::_exit(0);
            } catch (const std::exception& problem) {
                std::fprintf(stderr, "%s\n", problem.what());
                ::_exit(1);
            }
        }
        return child;
    }
    /// Parts are finished before the slice; then the disk fails.
    void stopAt(int slice, const std::string& name = "v.zarr") const {
        SlowSource failing(info_, values_);
        failing.errorAtZ = slice;
        MemoryBudget ram("RAM", "--ram", kPlenty);
        EXPECT_THROW(importToStore(failing, scratch_ / name, ram, options()), Error);
    }
    Files oneRun() const {
        ImportOptions how = options();
        how.key.clear();
        import("one.zarr", how);
        Files files = filesIn(scratch_ / "one.zarr");
        fs::remove_all(scratch_ / "one.zarr");
        return files;
    }
    void expectDone(const Files& expected) const {
        EXPECT_TRUE(filesIn(scratch_ / "v.zarr") == expected);
        EXPECT_EQ(entriesIn(scratch_.path()), 1u);
    }
    /// What is left after the next command looks into the folder.
    std::vector<std::string> recoveredNames() const {
        recoverFolders(scratch_.path());
        std::vector<std::string> names;
        for (const auto& entry : fs::directory_iterator(scratch_.path()))
            names.push_back(entry.path().filename());
        return names;
    }
    fs::path work(const std::string& key = kKey) const { return scratch_ / (".v.zarr.importing-" + key); }

    const ScratchFolder scratch_;
    VolumeInfo info_ = plainInfo({40, 36, 200}, ValueType::i16);
    HashSource::Formula values_ = [](int x, int y, int z) { return (x * 7 + y * y + z * 13) % 997; };
    Codec codec_ = Codec::lz4;
    int partSlices_ = 64, sliceMicroseconds_ = 0;
};

// The way by parts gives the bytes of one writer of the whole volume.
TEST_F(Resume, CutsDoNotShow) {
    for (const auto& [extent, type] :
         std::vector<std::pair<glm::ivec3, ValueType>>{{{40, 36, 200}, ValueType::i16},
                                                       {{33, 5, 129}, ValueType::f32},
                                                       {{9, 530, 1100}, ValueType::u8},
                                                       {{1, 1, 1}, ValueType::u16}}) {
        info_ = plainInfo(extent, type);
        MemoryBudget ram("RAM", "--ram", kPlenty);
        StoreWriter writer(scratch_ / "whole.zarr", info_, ram, 2, false);
        const std::unique_ptr<SlabSource> slices = source();
        while (const int count = writer.nextSlices()) {
            slices->readSlices(count, writer.next());
            writer.push();
        }
        writer.finish(info_);
        writer.commit(false);
        const Files whole = filesIn(scratch_ / "whole.zarr");
        fs::remove_all(scratch_ / "whole.zarr");
        Files first;
        for (const int slices : {32, 64, 256, 512, 1024}) {
            SCOPED_TRACE(std::to_string(extent.z) + " slices in parts of " + std::to_string(slices));
            partSlices_ = slices;
            Files files = oneRun();
            if (first.empty())
                first = files;
            EXPECT_TRUE(files == first);
            std::erase_if(files, [](const auto& file) { return file.first.starts_with("stats/"); });
            EXPECT_TRUE(files == whole);
        }
    }
}

TEST_F(Resume, AfterAKillAtEveryWrite) {
    info_.extentVoxels = {34, 12, 140};
    for (const int slices : {64, 32}) {
        partSlices_ = slices;
        const Files expected = oneRun();
        int kills = 0, found = 0;
        for (bool isKilled = true; isKilled; kills += slices == 64 ? 1 : 5) {
            isKilled = killedAt(kills, options());
            if (!fs::exists(scratch_ / "v.zarr"))
                found += import("v.zarr", options()).partsFound;
            else
                EXPECT_EQ(recoveredNames(), std::vector<std::string>{"v.zarr"});
            ASSERT_TRUE(filesIn(scratch_ / "v.zarr") == expected) << "killed at change " << kills;
            ASSERT_EQ(entriesIn(scratch_.path()), 1u) << "killed at change " << kills;
            fs::remove_all(scratch_ / "v.zarr");
        }
        EXPECT_GT(kills, 100);
        EXPECT_GT(found, kills / 2) << "what was finished is not made again";
    }
}

// Large ones: three parts of the real size.
TEST_F(Resume, OfAnyCodec) {
    info_.extentVoxels = {34, 12, 140};
    for (const Codec codec : {Codec::zstd, Codec::none}) {
        codec_ = codec;
        partSlices_ = 1024;
        const Files whole = oneRun();
        partSlices_ = 64;
        EXPECT_TRUE(oneRun() == whole);
        for (const int kill : {30, 70, 110, 150}) {
            killedAt(kill, options());
            if (!fs::exists(scratch_ / "v.zarr"))
                import("v.zarr", options());
            EXPECT_TRUE(filesIn(scratch_ / "v.zarr") == whole) << nameOf(codec) << " " << kill;
            fs::remove_all(scratch_ / "v.zarr");
        }
    }
}

TEST_F(Resume, AfterKillsAtRandomMoments) {
    info_ = plainInfo({24, 20, 1100}, ValueType::u8);
    values_ = [](int x, int y, int z) { return (x * 7 + y * y + z * 13) % 251; };
    partSlices_ = kPartSlices;
    sliceMicroseconds_ = 20;
    const Files expected = oneRun();
    std::mt19937 random(std::random_device{}());
    double whole = 0.1;
    int kills = 0, found = 0;
    for (int runs = 0; kills < 50 && runs < 300 && !HasFailure(); ++runs) {
        const auto began = std::chrono::steady_clock::now();
        const pid_t child = started(options());
        ::usleep(static_cast<useconds_t>(1e6 * std::uniform_real_distribution<double>(0, whole)(random)));
        ::kill(child, SIGKILL);
        if (ended(child) == -1)
            ++kills, whole *= 1.05;
        else
            whole = secondsSince(began);
        if (!fs::exists(scratch_ / "v.zarr"))
            found += import("v.zarr", options()).partsFound;
        recoveredNames();
        expectDone(expected);
        fs::remove_all(scratch_ / "v.zarr");
    }
    EXPECT_EQ(kills, 50);
    EXPECT_GT(found, 0);
    std::printf("50 kills in %.3f s each at most; %d parts were found\n", whole, found);
}

TEST_F(Resume, SeveralProcessesShareOne) {
    const Files expected = oneRun();
    sliceMicroseconds_ = 300;
    ImportOptions how = options();
    how.shared = true;
    std::mt19937 random(std::random_device{}());
    for (const int workers : {2, 4})
        for (const bool isOneKilled : {false, true}) {
            SCOPED_TRACE(std::to_string(workers) + " workers");
            std::vector<pid_t> children;
            for (int i = 0; i < workers; ++i)
                children.push_back(started(how));
            if (isOneKilled) {
                ::usleep(std::uniform_int_distribution<useconds_t>(1000, 50000)(random));
                ::kill(children.front(), SIGKILL);
            }
            for (std::size_t i = 0; i < children.size(); ++i)
                EXPECT_TRUE(ended(children[i]) == 0 || (isOneKilled && i == 0));
            expectDone(expected);
            EXPECT_EQ(ended(started(how)), 0) << "one that comes late";
            info_.unit = "counts";
            EXPECT_THROW(import("v.zarr", how), InputError) << "another volume's store";
            info_.unit.clear();
            const auto plain = values_;
            values_ = [plain](int x, int y, int z) {
                return x == 39 && y == 35 && z == 7 ? 1 - plain(x, y, z) : plain(x, y, z);
            };
            EXPECT_THROW(import("v.zarr", how), InputError) << "another scan of that machine";
            values_ = plain;
            fs::remove_all(scratch_ / "v.zarr");
        }
}

TEST_F(Resume, WhereOtherMachinesMayBeAtWork) {
    const Files expected = oneRun();
    hasLocks = false;
    ImportOptions how = options();
    how.shared = true;
    std::vector<pid_t> children;
    for (int i = 0; i < 3; ++i)
        children.push_back(started(how));
    for (const pid_t child : children)
        EXPECT_EQ(ended(child), 0);
    expectDone(expected);
    fs::remove_all(scratch_ / "v.zarr");
    for (const bool isShared : {true, false}) {
        how.shared = isShared;
        EXPECT_TRUE(killedAt(150, how));
        const int kept = WorkFolder::partsOf(scratch_ / "v.zarr", kKey);
        EXPECT_GT(kept, 0);
        recoverFolders(scratch_.path());
        for (const auto& entry : fs::directory_iterator(work()))
            if (Claims::nameOf(entry.path().filename().string())) // a minute goes by
                fs::last_write_time(entry.path(), fs::file_time_type::clock::now() - std::chrono::minutes(2));
        EXPECT_EQ(import("v.zarr", how).partsFound, kept);
        expectDone(expected);
        fs::remove_all(scratch_ / "v.zarr");
    }
    hasLocks = true;
}

TEST_F(Resume, OneAtATimeUnlessTheyShare) {
    const WorkFolder first(scratch_ / "v.zarr", {kKey, false});
    EXPECT_THAT([&] { import("v.zarr", options()); },
                ThrowsMessage<InputError>(AllOf(HasSubstr("v.zarr"), HasSubstr("--share"))));
    ImportOptions how = options();
    how.shared = true;
    EXPECT_THROW(import("v.zarr", how), InputError);
    how.key = kOther; // of another source: by itself
    how.shared = false;
    EXPECT_EQ(import("v.zarr", how).parts, 4);
    EXPECT_TRUE(fs::exists(first.path()));
}

TEST_F(Resume, OneAtATimeGoesOn) {
    stopAt(150);
    const WorkFolder first(scratch_ / "v.zarr", {kKey, false});
    EXPECT_THAT([&] { import("v.zarr", options()); }, ThrowsMessage<InputError>(HasSubstr("--share")));
    EXPECT_EQ(WorkFolder::partsOf(scratch_ / "v.zarr", kKey), 2);
}

TEST_F(Resume, GoesOnAfterADiskFails) {
    const Files expected = oneRun();
    stopAt(150);
    EXPECT_EQ(WorkFolder::partsOf(scratch_ / "v.zarr", kKey), 2);
    const ImportReport report = import("v.zarr", options());
    EXPECT_EQ(report.parts, 4);
    EXPECT_EQ(report.partsFound, 2);
    EXPECT_EQ(report.bytesIn, 40u * 36 * 200 * 2);
    expectDone(expected);
}

// After a crash no part counts whose data are lost.
TEST_F(Resume, PartsAreOnTheDiskBeforeTheyCount) {
    for (const bool isDurable : {true, false})
        for (const int slices : {64, 512}) { // of one part nothing is kept, so nothing waits
            partSlices_ = slices;
            ImportOptions how = options();
            how.durable = isDurable;
            order.clear();
            import(std::to_string(slices) + (isDurable ? "d.zarr" : ".zarr"), how);
            const std::string each = isDurable && slices < 200 ? "sp" : "p";
            std::string expected = each;
            for (int part = 1; part < (200 - 1) / slices + 1; ++part)
                expected += each;
            EXPECT_EQ(order, expected + (isDurable ? "s" : ""));
        }
}

TEST_F(Resume, NothingIsKeptOfASourceAtFault) {
    HashSource failing(info_, values_);
    failing.failAtZ = 150;
    MemoryBudget ram("RAM", "--ram", kPlenty);
    EXPECT_THROW(importToStore(failing, scratch_ / "v.zarr", ram, options()), InputError);
    EXPECT_EQ(entriesIn(scratch_.path()), 0u);
}

TEST_F(Resume, ASourceThatChangesMeanwhileIsRefused) {
    for (const int looks : {0, 2, 4}) { // one a part, and one before the store gets its name
        ImportOptions how = options();
        how.checkSource = [left = looks]() mutable {
            if (left-- == 0)
                throw badFile("source", "the files of before", "others");
        };
        EXPECT_THROW(import("v.zarr", how), InputError);
        EXPECT_EQ(entriesIn(scratch_.path()), 0u) << looks;
    }
}

// Each looks for leftovers of the others, and must not keep them from their work.
TEST_F(Resume, ManyImportsIntoOneFolder) {
    info_.extentVoxels = {8, 8, 130};
    std::vector<pid_t> children;
    for (int i = 0; i < 6; ++i)
        if (children.push_back(::fork()); children.back() == 0) {
            ImportOptions how = options();
            how.shared = i % 2;
            try {
                for (int run = 0; run < 25; ++run) {
                    stopAt(100, "v" + std::to_string(i) + ".zarr");
                    import("v" + std::to_string(i) + ".zarr", how);
                    fs::remove_all(scratch_ / ("v" + std::to_string(i) + ".zarr"));
                }
            } catch (const std::exception& problem) {
                std::fprintf(stderr, "%s\n", problem.what());
                ::_exit(1);
            }
            ::_exit(HasFailure());
        }
    for (const pid_t child : children)
        EXPECT_EQ(ended(child), 0);
    recoverFolders(scratch_.path());
    EXPECT_EQ(entriesIn(scratch_.path()), 0u);
}

TEST_F(Resume, AnotherSourceIsNotContinuedAndReplacesWhatIsLeft) {
    stopAt(150);
    values_ = [](int x, int y, int z) { return x + y + z; };
    const Files expected = oneRun();
    EXPECT_TRUE(fs::exists(work())) << "another store in the same folder leaves it alone";
    ImportOptions how = options();
    how.key = kOther;
    EXPECT_EQ(import("v.zarr", how).partsFound, 0);
    expectDone(expected);
}

TEST_F(Resume, LeftoversWithoutAFinishedPartGo) {
    EXPECT_TRUE(killedAt(8, options()));
    EXPECT_TRUE(fs::exists(work()));
    EXPECT_EQ(WorkFolder::partsOf(scratch_ / "v.zarr", kKey), 0);
    recoverFolders(scratch_.path());
    EXPECT_EQ(entriesIn(scratch_.path()), 0u);
    stopAt(150);
    recoverFolders(scratch_.path());
    EXPECT_TRUE(fs::exists(work()));
}

TEST_F(Resume, ADamagedPartIsMadeAgain) {
    const Files expected = oneRun();
    const auto damages = std::vector<std::function<void(const fs::path&)>>{
        [](const fs::path& part) { fs::remove(part / "part.json"); },
        [](const fs::path& part) { fs::resize_file(part / "0/c/0/0/0", 99); },
        [](const fs::path& part) { fs::remove(part / "rest"); },
        [](const fs::path& part) { fs::remove_all(part / "1"); },
        [](const fs::path& part) {
            std::string text = fileText(part / "part.json");
            const std::string counted = "\"nonFiniteVoxels\": 0";
            text.replace(text.find(counted), counted.size(), "\"nonFiniteVoxels\": 7");
            setFileText(part / "part.json", text);
        },
        [](const fs::path& part) { // another's place
            fs::remove_all(part);
            fs::copy(part.parent_path() / "part-0000", part, fs::copy_options::recursive);
        }};
    for (const auto& damage : damages) {
        stopAt(195);
        damage(work() / "part-0001");
        EXPECT_EQ(import("v.zarr", options()).partsFound, 2);
        expectDone(expected);
        fs::remove_all(scratch_ / "v.zarr");
    }
}

// Only processes that share an import may have made the store.
TEST_F(Resume, AnImportWhoseFolderGoesIsNotTakenForDone) {
    import("v.zarr", options());
    const Files before = filesIn(scratch_ / "v.zarr");
    values_ = [this](int x, int y, int z) {
        if (x + y == 0 && z == 130)
            fs::remove_all(work() / "store");
        return x + y + z;
    };
    ImportOptions how = options();
    how.force = true;
    EXPECT_THAT([&] { import("v.zarr", how); }, ThrowsMessage<Error>(HasSubstr("was removed meanwhile")));
    EXPECT_TRUE(filesIn(scratch_ / "v.zarr") == before);
}

TEST_F(Resume, WhatIsFinishedStaysWhereTheNameIsTakenMeanwhile) {
    const Files expected = oneRun();
    const auto plain = values_;
    values_ = [this, plain](int x, int y, int z) {
        if (x + y == 0 && z == 190)
            fs::create_directory(scratch_ / "v.zarr");
        return plain(x, y, z);
    };
    EXPECT_THROW(import("v.zarr", options()), InputError);
    EXPECT_EQ(WorkFolder::partsOf(scratch_ / "v.zarr", kKey), 4);
    fs::remove(scratch_ / "v.zarr");
    values_ = plain;
    EXPECT_EQ(import("v.zarr", options()).partsFound, 4);
    expectDone(expected);
}

TEST_F(Resume, ReplacingGoesOnToo) {
    const Files expected = oneRun();
    info_.extentVoxels.z = 10;
    ImportOptions how = options();
    how.key = kOther;
    import("v.zarr", how);
    info_.extentVoxels.z = 200;
    stopAt(150); // refused before anything is written: there is a store
    how = options();
    how.force = true;
    for (int change = 200; change < 700 && !HasFailure(); change += 7) {
        killedAt(change, how);
        EXPECT_TRUE(isStore(scratch_ / "v.zarr")) << "the old one or the new one";
        import("v.zarr", how);
        expectDone(expected);
    }
}

} // namespace
} // namespace tessera
