// tests/program/kill_test.cpp: kill -9 at random moments. Never half a store or half a picture under a final
// name, and nothing is left after the next run but what that run made. TESSERA_KILLS=100
// build/release/kill_test is the long form: so many kills of each kind; without it a few.
#include "tests/support/program_fixture.h"

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <map>
#include <random>

namespace tessera::test {
namespace {

using Clock = std::chrono::steady_clock;

int kills() {
    const char* const asked = std::getenv("TESSERA_KILLS");
    return asked ? std::max(1, std::atoi(asked)) : 3;
}

/// Every file below a folder with its bytes, by relative path.
std::map<std::string, std::string> contentOf(const fs::path& folder) {
    std::map<std::string, std::string> all;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
        if (entry.is_regular_file())
            all[entry.path().lexically_relative(folder)] = readAll(entry.path());
    return all;
}

class Kill : public Program {
  protected:
    void SetUp() override {
        makeSource("v", 1);
        makeSource("w", 2);
        fs::create_directory(folder_ / "tmp");
        ::setenv("TMPDIR", (folder_ / "tmp").c_str(), 1);
    }
    void TearDown() override { ::unsetenv("TMPDIR"); }
    /// A raw volume whose values are not all the same, so that the store has shards of some size.
    void makeSource(const std::string& name, unsigned seed, int across = 96, int slices = 160) {
        std::mt19937 random(seed);
        std::string voxels(static_cast<std::size_t>(across * across * slices), '\0');
        for (char& voxel : voxels)
            voxel = static_cast<char>(random() & 0x1F);
        write(name + ".raw", voxels);
        write(name + ".json", R"({"data":")" + name + R"(.raw","type":"uint8","extent":[)" +
                                  std::to_string(across) + "," + std::to_string(across) + "," +
                                  std::to_string(slices) + R"(],"spacing":[1,1,1]})");
    }
    pid_t start(const std::string& arguments) const {
        std::vector<std::string> words = {"tessera"};
        std::istringstream text(arguments);
        for (std::string word; text >> word;)
            words.push_back(word);
        const pid_t child = ::fork();
        if (child == 0)
            ::_exit(runInChild(words));
        return child;
    }
    /// Runs it once whole, for its time, then until `kills()` kills at random moments hit it at work, with
    /// `before` and `after` around each run.
    void killAtRandom(const std::string& arguments, const std::function<void()>& before,
                      const std::function<void()>& after) {
        before();
        auto began = Clock::now();
        int status = 0;
        ::waitpid(start(arguments), &status, 0);
        EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << readAll(folder_ / ".err");
        const auto secondsGone = [&] { return std::chrono::duration<double>(Clock::now() - began).count(); };
        double whole = secondsGone(); // the disk's mood changes it: what runs take is followed
        after();
        int hits = 0, runs = 0;
        for (; hits < kills() && runs < 10 * kills() && !HasFailure(); ++runs) {
            before();
            const double moment = std::uniform_real_distribution<double>(0, whole)(random_);
            began = Clock::now();
            const pid_t child = start(arguments);
            bool ended = false;
            while (!ended && secondsGone() < moment) {
                ended = ::waitpid(child, &status, WNOHANG) == child;
                ::usleep(500);
            }
            if (ended) {
                whole = (whole + secondsGone()) / 2;
            } else {
                ::kill(child, SIGKILL);
                ::waitpid(child, &status, 0);
                whole *= 1.02; // else it would only shrink
                hits += WIFSIGNALED(status);
            }
            SCOPED_TRACE("killed after " + std::to_string(moment) + " s");
            after();
        }
        EXPECT_EQ(hits, kills());
        std::printf("%d kills in %d runs of some %.3f s: tessera %s\n", hits, runs, whole, arguments.c_str());
        std::fflush(stdout);
    }
    /// Names in a folder of the test's, without what the fixture makes.
    std::vector<std::string> names(const std::string& folder = ".") const {
        std::vector<std::string> all;
        std::error_code ignored;
        for (const auto& entry : fs::directory_iterator(folder_ / folder, ignored))
            if (const std::string name = entry.path().filename(); name != ".out" && name != ".err")
                all.push_back(name);
        std::sort(all.begin(), all.end());
        return all;
    }
    std::map<std::string, std::string> imported(const std::string& name) {
        EXPECT_EQ(run("import " + name + ".json expected.zarr --force").exitCode, 0);
        auto content = contentOf(folder_ / "expected.zarr");
        fs::remove_all(folder_ / "expected.zarr");
        return content;
    }
    const std::vector<std::string> given_ = {"tmp", "v.json", "v.raw", "w.json", "w.raw"};
    std::vector<std::string> givenAnd(const std::vector<std::string>& more) const {
        std::vector<std::string> all = given_;
        all.insert(all.end(), more.begin(), more.end());
        std::sort(all.begin(), all.end());
        return all;
    }
    std::mt19937 random_{std::random_device{}()};
};

#if TESSERA_WITH_IMPORT
TEST_F(Kill, AnImportIsWholeOrNotThere) {
    const auto whole = imported("v");
    killAtRandom(
        "import v.json out.zarr", [&] { fs::remove_all(folder_ / "out.zarr"); },
        [&] {
            if (exists("out.zarr")) {
                EXPECT_EQ(contentOf(folder_ / "out.zarr"), whole);
            }
            EXPECT_EQ(run("import v.json out.zarr --force").exitCode, 0);
            EXPECT_EQ(names(), givenAnd({"out.zarr"}));
            EXPECT_EQ(contentOf(folder_ / "out.zarr"), whole);
            EXPECT_EQ(names("tmp"), std::vector<std::string>{});
        });
}

TEST_F(Kill, TheSameImportGoesOn) {
    makeSource("long", 3, 24, 1060); // three parts
    const auto whole = imported("long");
    const std::string import = "import long.json out.zarr";
    int found = 0;
    killAtRandom(
        import, [&] { fs::remove_all(folder_ / "out.zarr"); },
        [&] {
            if (!exists("out.zarr")) {
                const Outcome next = run(import);
                EXPECT_EQ(next.exitCode, 0) << next.problems;
                found += next.problems.find("of 3 parts were there") != std::string::npos;
            }
            EXPECT_EQ(run("import v.json other.zarr --force").exitCode, 0); // removes what is of no use
            EXPECT_EQ(names(), givenAnd({"long.json", "long.raw", "other.zarr", "out.zarr"}));
            EXPECT_TRUE(contentOf(folder_ / "out.zarr") == whole);
        });
    std::printf("parts were found in %d runs\n", found);
}

TEST_F(Kill, ASharedImportOutlivesAProcess) {
    makeSource("long", 3, 24, 1060);
    const auto whole = imported("long");
    pid_t other = -1;
    int status = 0;
    killAtRandom(
        "import long.json out.zarr --share",
        [&] {
            fs::remove_all(folder_ / "out.zarr");
            other = start("import long.json out.zarr --share");
        },
        [&] {
            ::waitpid(other, &status, 0);
            EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << readAll(folder_ / ".err");
            EXPECT_EQ(run("import long.json out.zarr --share").exitCode, 0);
            EXPECT_EQ(names(), givenAnd({"long.json", "long.raw", "out.zarr"}));
            EXPECT_TRUE(contentOf(folder_ / "out.zarr") == whole);
        });
}

TEST_F(Kill, AReplacedStoreIsTheOldOrTheNew) {
    const auto before = imported("v"), after = imported("w");
    int old = 0;
    killAtRandom(
        "import w.json out.zarr --force",
        [&] { ASSERT_EQ(run("import v.json out.zarr --force").exitCode, 0); },
        [&] {
            const auto now = contentOf(folder_ / "out.zarr");
            EXPECT_TRUE(now == before || now == after);
            old += now == before;
            EXPECT_EQ(run("import v.json out.zarr --force").exitCode, 0);
            EXPECT_EQ(names(), givenAnd({"out.zarr"}));
            EXPECT_EQ(contentOf(folder_ / "out.zarr"), before);
        });
    std::printf("the old store %d times, else the new one\n", old);
}

TEST_F(Kill, AnExportLeavesTheOldFileOrTheNew) {
    ASSERT_EQ(run("import v.json s.zarr").exitCode, 0);
    ASSERT_EQ(run("export s.zarr out.nrrd --compress").exitCode, 0);
    const std::string whole = readAll(folder_ / "out.nrrd");
    killAtRandom(
        "export s.zarr out.nrrd --compress --force", [&] { write("out.nrrd", "old"); },
        [&] {
            const std::string now = readAll(folder_ / "out.nrrd");
            EXPECT_TRUE(now == "old" || now == whole);
            EXPECT_EQ(run("export s.zarr out.nrrd --compress --force").exitCode, 0);
            EXPECT_EQ(readAll(folder_ / "out.nrrd"), whole);
            EXPECT_EQ(names(), givenAnd({"out.nrrd", "s.zarr"}));
        });
}

// What the next render finds of an import in the cache: its finished parts. The store is that of one run.
TEST_F(Kill, AnImportInTheCacheGoesOn) {
    makeSource("long", 3, 24, 1060); // three parts
    const std::string render = "render long.json -o a.png --engine mirror --size 8x8 --step 4 --preset auto";
    const auto stores = [&] {
        std::vector<std::string> all = names("cache/tessera");
        std::erase_if(all, [](const std::string& name) { return !name.ends_with(".zarr"); });
        return all;
    };
    const auto content = [&] { return contentOf(folder_ / "cache/tessera" / stores().at(0)); };
    ASSERT_EQ(run(render).exitCode, 0);
    const auto whole = content();
    int found = 0, listed = 0;
    killAtRandom(
        render, [&] { fs::remove_all(folder_ / "cache"); },
        [&] {
            const bool isUnfinished = run("cache list").out.find("unfinished") != std::string::npos;
            listed += isUnfinished;
            const Outcome next = run(render);
            EXPECT_EQ(next.exitCode, 0) << next.problems;
            const bool goesOn = next.problems.find("of 3 parts were there") != std::string::npos;
            found += goesOn;
            EXPECT_LE(goesOn, isUnfinished);
            EXPECT_EQ(stores().size(), 1u);
            EXPECT_TRUE(content() == whole);
            EXPECT_EQ(names("cache/tessera").size(), 3u) << "a store, its note and its lock";
        });
    std::printf("parts were found in %d runs, listed in %d\n", found, listed);
    // Killed once a part is finished: the next run goes on with it, unless the machine is so slow to kill
    // that all was done.
    const auto hasPart = [&] {
        std::error_code ignored;
        for (fs::recursive_directory_iterator at(folder_ / "cache/tessera", ignored), end; at != end;
             at.increment(ignored))
            if (at->path().filename() == "part.json")
                return true;
        return false;
    };
    bool goesOn = false;
    for (int trial = 0; trial < 20 && !goesOn; ++trial) {
        fs::remove_all(folder_ / "cache");
        const pid_t child = start(render);
        int status = 0;
        while (!hasPart() && ::waitpid(child, &status, WNOHANG) == 0)
            ;
        ::kill(child, SIGKILL);
        ::waitpid(child, &status, 0);
        goesOn = run(render).problems.find("of 3 parts were there") != std::string::npos;
        EXPECT_TRUE(content() == whole);
    }
    EXPECT_TRUE(goesOn);
}

TEST_F(Kill, ARenderLeavesTheOldPictureOrTheNewAndAWholeCache) {
    const std::string render = "render v.json -o a.png --engine mirror --size 96x96 --step 2 --preset auto";
    ASSERT_EQ(run(render).exitCode, 0);
    const std::string whole = readAll(folder_ / "a.png");
    const auto pixels = [](const std::string& png) {
        return png.substr(std::min(png.size(), png.find("IDAT")));
    };
    killAtRandom(
        render,
        [&] {
            fs::remove_all(folder_ / "cache"); // a folder that is not imported yet
            write("a.png", "old");
        },
        [&] {
            const std::string now = readAll(folder_ / "a.png");
            EXPECT_TRUE(now == "old" || pixels(now) == pixels(whole));
            const Outcome next = run(render);
            EXPECT_EQ(next.exitCode, 0) << next.problems;
            EXPECT_EQ(pixels(readAll(folder_ / "a.png")), pixels(whole));
            EXPECT_EQ(names(), givenAnd({"a.png", "cache"}));
            EXPECT_EQ(names("tmp"), std::vector<std::string>{});
            const std::vector<std::string> kept = names("cache/tessera");
            EXPECT_EQ(kept.size(), 3u) << "a store, its note and its lock";
            for (const std::string& name : kept)
                EXPECT_NE(name.front(), '.') << name;
        });
}
#endif

} // namespace
} // namespace tessera::test
