// tests/program/cache_test.cpp: source files that are rendered straight away are imported once, whoever asks,
// and again when anything about them or about the import has changed.
#include "core/base/error.h"
#include "tests/support/program_fixture.h"
#include "viewer/cli/input/import_cache.h"

#include <chrono>
#include <fcntl.h>
#include <nlohmann/json.hpp>
#include <sys/file.h>
#include <sys/stat.h>

namespace tessera::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

#if TESSERA_WITH_IMPORT
class ImportCache : public Program {
  protected:
    void SetUp() override { makeSource("v", 40); }
    void makeSource(const std::string& name, int value) {
        write(name + ".raw", std::string(24 * 24 * 24, static_cast<char>(value)) + std::string(24 * 24, 'z'));
        write(name + ".json",
              R"({"data":")" + name + R"(.raw","type":"uint8","extent":[24,24,25],"spacing":[1,1,1]})");
    }
    Outcome render(const std::string& name, const std::string& more = "") {
        return run("render " + name + ".json -v -o a.png --engine mirror --size 8x8 " + more);
    }
    fs::path place() const { return folder_ / "cache/tessera"; }
    /// Paths of that extension in the cache.
    std::vector<fs::path> entries(const std::string& extension = ".zarr") const {
        std::vector<fs::path> found;
        std::error_code ignored;
        for (const auto& entry : fs::directory_iterator(place(), ignored))
            if (entry.path().extension() == extension)
                found.push_back(entry.path());
        return found;
    }
    const ::testing::Matcher<std::string> imported = HasSubstr("importing raw"),
                                          reused = HasSubstr("reusing");
};

TEST_F(ImportCache, IsUsedAgainAndPrivate) {
    const Outcome first = render("v");
    ASSERT_EQ(first.exitCode, 0) << first.problems;
    EXPECT_THAT(first.problems, Not(reused));
    EXPECT_THAT(render("v").problems, reused);
    ASSERT_EQ(entries().size(), 1u);
    EXPECT_EQ(fs::status(place()).permissions(), fs::perms::owner_all);
    EXPECT_EQ(fs::status(entries(".json").front()).permissions(),
              fs::perms::owner_read | fs::perms::owner_write);
    fs::permissions(place(), fs::perms::owner_all | fs::perms::others_read | fs::perms::others_exec);
    EXPECT_EQ(render("v").exitCode, 0);
    EXPECT_EQ(fs::status(place()).permissions(), fs::perms::owner_all) << "closed again";
}

// The same size and the same time, as a file that was put back has them.
TEST_F(ImportCache, ChangedFilesAreImportedAnew) {
    ASSERT_EQ(render("v").exitCode, 0);
    const fs::path before = entries().front();
    const auto time = fs::last_write_time(folder_ / "v.raw");
    makeSource("v", 90);
    fs::last_write_time(folder_ / "v.raw", time);
    fs::last_write_time(folder_ / "v.json", time);
    const Outcome again = render("v");
    EXPECT_EQ(again.exitCode, 0);
    EXPECT_THAT(again.problems, Not(reused));
    ASSERT_EQ(entries().size(), 2u) << "the one before stays for its figures";
    makeSource("v", 70);
    ASSERT_EQ(render("v").exitCode, 0);
    EXPECT_EQ(entries().size(), 2u) << "but no older one";
    EXPECT_FALSE(fs::exists(before));
}

// A header's own facts stay the same: the voxels lie in another file.
TEST_F(ImportCache, ChangedFilesThatHeadersNameAreImportedAnew) {
    const std::string sizes = "24 24 25";
    write("h.nhdr", "NRRD0005\ntype: uchar\ndimension: 3\nsizes: " + sizes +
                        "\nencoding: raw\nspacings: 1 1 1\nunits: \"mm\" \"mm\" \"mm\"\ndata file: v.raw\n");
    write("h.mhd", "ObjectType = Image\nNDims = 3\nDimSize = " + sizes +
                       "\nElementType = MET_UCHAR\nElementSpacing = 1 1 1\nElementDataFile = v.raw\n");
    fs::create_directory(folder_ / "headers");
    write("headers/h.mhd", "ObjectType = Image\nNDims = 3\nDimSize = " + sizes +
                               "\nElementType = MET_UCHAR\nElementSpacing = 1 1 1\n"
                               "ElementDataFile = ../v.raw\n");
    fs::create_directory(folder_ / "links");
    fs::create_symlink(folder_ / "h.mhd", folder_ / "links/h.mhd"); // its data lie beside the link
    const auto writeVoxels = [&](char value) {
        for (const char* name : {"v.raw", "links/v.raw"})
            write(name, std::string(24 * 24 * 24, value) + std::string(24 * 24, 'z'));
    };
    for (const char* name : {"v.json", "h.nhdr", "h.mhd", "headers", "links/h.mhd"}) {
        const auto render = [&] {
            return run(std::string("render ") + name + " -v -o a.png --engine mirror --size 8x8");
        };
        writeVoxels('a');
        const Outcome first = render();
        ASSERT_EQ(first.exitCode, 0) << first.problems;
        EXPECT_THAT(first.problems, Not(reused)) << name;
        EXPECT_THAT(render().problems, reused) << name;
        writeVoxels('b');
        EXPECT_THAT(render().problems, Not(reused)) << name;
    }
}

TEST_F(ImportCache, ADamagedEntryIsImportedAnew) {
    ASSERT_EQ(render("v").exitCode, 0);
    const std::string good = readAll(folder_ / "a.png");
    const fs::path store = entries().front();
    const std::vector<std::function<void()>> damages = {
        [&] { // one bit of the voxels
            const fs::path shard = store / "0/c/0/0/0";
            std::string bytes = readAll(shard);
            ASSERT_GT(bytes.size(), 8u);
            bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 4);
            std::ofstream(shard, std::ios::binary) << bytes;
        },
        [&] { fs::remove_all(store / "2"); },
        [&] { fs::remove(store / "zarr.json"); },
        [&] { std::ofstream(store / "zarr.json") << "{}"; },
        [&] { std::ofstream(entries(".json").front()) << "{\"check\": [1]}"; },
        [&] { fs::remove(entries(".json").front()); },
        [&] {
            fs::remove_all(store);
            std::ofstream(store) << "no folder";
        },
    };
    for (const auto& damage : damages) {
        damage();
        const Outcome again = render("v");
        EXPECT_EQ(again.exitCode, 0) << again.problems;
        EXPECT_THAT(again.problems, Not(reused));
        EXPECT_EQ(readAll(folder_ / "a.png").size(), good.size());
        EXPECT_EQ(entries().size(), 1u);
        EXPECT_THAT(render("v").problems, reused);
    }
}

// One imports, the others wait for it or find it done.
TEST_F(ImportCache, OfManyAtOnceOneImports) {
    constexpr int kMany = 24;
    std::vector<pid_t> children;
    for (int i = 0; i < kMany; ++i) {
        const pid_t child = ::fork();
        if (child == 0) {
            std::string name = std::to_string(i);
            fs::create_directory(folder_ / name);
            fs::current_path(folder_ / name);
            ::setenv("XDG_CACHE_HOME", (folder_ / "cache").c_str(), 1);
            std::vector<std::string> words = {"tessera", "render",   "../v.json", "-v",     "-o",
                                              "a.png",   "--engine", "mirror",    "--size", "8x8"};
            std::vector<char*> argv;
            for (std::string& word : words)
                argv.push_back(word.data());
            argv.push_back(nullptr);
            if (!std::freopen("err", "w", stderr))
                ::_exit(100);
            const int code = runProgram(static_cast<int>(words.size()), argv.data());
            std::fflush(nullptr);
            ::_exit(code);
        }
        children.push_back(child);
    }
    int imports = 0;
    for (int i = 0; i < kMany; ++i) {
        int status = 0;
        ::waitpid(children[static_cast<std::size_t>(i)], &status, 0);
        const std::string said = readAll(folder_ / std::to_string(i) / "err");
        EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << said;
        imports += said.find("reusing") == std::string::npos;
    }
    EXPECT_EQ(imports, 1);
    EXPECT_EQ(entries().size(), 1u);
}

TEST_F(ImportCache, WhoWaitsSaysSoAndCanBeInterrupted) {
    ASSERT_EQ(render("v").exitCode, 0);
    const fs::path lock = entries(".lock").front();
    const int held = ::open(lock.c_str(), O_RDWR);
    ASSERT_EQ(::flock(held, LOCK_EX), 0); // an import that takes long
    const pid_t child = ::fork();
    if (child == 0) {
        std::vector<std::string> words = {"tessera",  "render", "v.json", "-o", "b.png",
                                          "--engine", "mirror", "--size", "8x8"};
        ::close(held);
        ::_exit(runInChild(words));
    }
    std::string said;
    for (int i = 0; i < 500 && said.find("waiting") == std::string::npos; ++i) {
        ::usleep(10000);
        said = readAll(folder_ / ".err");
    }
    EXPECT_THAT(said, HasSubstr("waiting for another process that imports"));
    ::kill(child, SIGTERM);
    int status = 0;
    ::waitpid(child, &status, 0);
    ::close(held);
    EXPECT_EQ(WIFEXITED(status) ? WEXITSTATUS(status) : -1, 143);
}

TEST_F(ImportCache, HasABoundAndNothingInUseGoes) {
    ASSERT_EQ(::setenv("TESSERA_CACHE_SIZE", "1", 1), 0);
    ASSERT_EQ(render("v").exitCode, 0);
    const int used = ::open(entries(".lock").front().c_str(), O_RDONLY);
    ASSERT_EQ(::flock(used, LOCK_SH), 0); // a render that goes on
    makeSource("w", 60);
    ASSERT_EQ(render("w").exitCode, 0);
    EXPECT_EQ(entries().size(), 2u) << "one in use, one just made";
    ::close(used);
    makeSource("x", 70);
    ASSERT_EQ(render("x").exitCode, 0);
    EXPECT_EQ(entries().size(), 1u);
    ::setenv("TESSERA_CACHE_SIZE", "a lot", 1);
    expectRefused("render x.json -o a.png", {"TESSERA_CACHE_SIZE"});
    ::unsetenv("TESSERA_CACHE_SIZE");
}

// The entry used last stays, though it was made first.
TEST_F(ImportCache, TheLeastRecentlyUsedGoesFirst) {
    makeSource("w", 60);
    ASSERT_EQ(render("v").exitCode, 0);
    ASSERT_EQ(render("w").exitCode, 0);
    const auto age = [&](int hours) { // of the entries' last use, as seen now
        for (const fs::path& lock : entries(".lock"))
            fs::last_write_time(lock, fs::file_time_type::clock::now() - std::chrono::hours(hours));
    };
    age(5);
    EXPECT_THAT(render("v").problems, reused);
    const std::uint64_t one = nlohmann::json::parse(run("cache list --json").out)[0]["bytes"];
    ASSERT_EQ(::setenv("TESSERA_CACHE_SIZE", std::to_string(5 * one / 2).c_str(), 1), 0);
    makeSource("x", 70);
    ASSERT_EQ(render("x").exitCode, 0);
    ::unsetenv("TESSERA_CACHE_SIZE");
    EXPECT_EQ(entries().size(), 2u);
    EXPECT_THAT(render("v").problems, reused);
    EXPECT_THAT(render("w").problems, Not(reused));
}

// A folder that is still being copied: its import would be kept as if it were whole.
TEST_F(ImportCache, FilesThatChangeWhileTheyAreImportedAreRefused) {
    ::setenv("XDG_CACHE_HOME", (folder_ / "cache").c_str(), 1);
    CommonOptions common;
    common.progress = std::make_shared<Progress>();
    const auto makeAndTouch = [&](const StoreToMake& wanted) {
        ASSERT_EQ(run("phantom sphere --size 8x8x8 -o " + wanted.store.string()).exitCode, 0);
        makeSource("v", 41);
    };
    EXPECT_THROW(cachedStore(folder_ / "v.json", {}, common, makeAndTouch), InputError);
    EXPECT_TRUE(entries().empty());
    ::unsetenv("XDG_CACHE_HOME");
}

TEST_F(ImportCache, IsListedAndCleared) {
    EXPECT_EQ(run("cache path").out, place().string() + "\n");
    EXPECT_EQ(run("cache list").out, "");
    ASSERT_EQ(render("v").exitCode, 0);
    makeSource("w", 60);
    ASSERT_EQ(render("w").exitCode, 0);
    const Outcome listed = run("cache list");
    EXPECT_EQ(std::count(listed.out.begin(), listed.out.end(), '\n'), 2);
    EXPECT_THAT(listed.out, HasSubstr("24 x 24 x 25 voxels"));
    EXPECT_THAT(listed.out, Not(HasSubstr("v.json"))); // a path may hold a name
    EXPECT_THAT(listed.problems, HasSubstr("2 imports"));
    const auto json = nlohmann::json::parse(run("cache list --json").out);
    ASSERT_EQ(json.size(), 2u);
    EXPECT_GT(json[0]["bytes"].get<int>(), 1000);
    EXPECT_FALSE(json[0]["inUse"].get<bool>());
    write("cache/tessera/notes.txt", "somebody's");
    EXPECT_THAT(run("cache clear").problems, HasSubstr("removed 2 imports"));
    EXPECT_EQ(entries().size() + entries(".json").size() + entries(".lock").size(), 0u);
    EXPECT_TRUE(exists("cache/tessera/notes.txt"));
    EXPECT_EQ(run("cache list").exitCode, 0);
}

// The target of a link in the cache belongs to its owner: it is neither counted nor removed.
TEST_F(ImportCache, LinksAreNotFollowed) {
    ASSERT_EQ(render("v").exitCode, 0);
    write("precious.bin", std::string(3 << 20, 'p'));
    fs::create_directories(folder_ / "precious");
    write("precious/zarr.json", std::string(2 << 20, 'p'));
    fs::create_symlink(folder_ / "precious.bin", entries().front() / "link");
    fs::create_symlink(folder_ / "precious", place() / "0123456789abcdef.zarr");
    fs::remove(entries(".json").front()); // so that its bytes are counted
    const auto listed = nlohmann::json::parse(run("cache list --json").out);
    ASSERT_EQ(listed.size(), 2u);
    for (const auto& entry : listed)
        EXPECT_LT(entry["bytes"].get<std::uint64_t>(), 1u << 20) << entry;
    EXPECT_THAT(run("cache clear").problems, ::testing::ContainsRegex("removed 2 imports, [0-9.]+ KiB"));
    EXPECT_TRUE(entries().empty());
    EXPECT_EQ(fs::file_size(folder_ / "precious.bin"), std::uintmax_t{3} << 20);
    EXPECT_EQ(fs::file_size(folder_ / "precious/zarr.json"), std::uintmax_t{2} << 20);
}

TEST_F(ImportCache, APictureNeedsNoCache) {
    write("cache", "a file where the folder would be");
    const Outcome outcome = render("v");
    EXPECT_EQ(outcome.exitCode, 0) << outcome.problems;
    EXPECT_THAT(outcome.problems, HasSubstr("cannot be used"));
    EXPECT_TRUE(exists("a.png"));
}
#endif

} // namespace
} // namespace tessera::test
