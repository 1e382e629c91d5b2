// tests/program/ranks_test.cpp: `tessera render --ranks`, started by mpirun: pictures equal those of one
// process, composited by IceT; a process that dies or fails ends all, and leaves nothing half-written; what
// is refused.
#include "tests/support/program_fixture.h"

#include "core/image/image_file.h"

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <random>
#include <thread>

namespace tessera::test {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

class RankedPictures : public Program {
  protected:
    void SetUp() override {
        ASSERT_EQ(run("phantom torso --size 110x90x130 -o v.zarr").exitCode, 0);
        ASSERT_EQ(run("phantom sphere --size 40x33x24 -o s.zarr").exitCode, 0); // of few bricks
    }
    /// Runs `tessera arguments --ranks` in so many processes, inside the temporary folder.
    Outcome runRanks(int count, const std::string& arguments) const {
        int status = 0;
        ::waitpid(startRanks(count, arguments), &status, 0);
        return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, readAll(folder_ / ".out"),
                readAll(folder_ / ".err")};
    }
    pid_t startRanks(int count, const std::string& arguments) const {
        const std::string command = "cd " + folder_.path().string() + " && exec mpirun --oversubscribe " +
                                    "--allow-run-as-root -n " + std::to_string(count) +
                                    " " TESSERA_PROGRAM " " + arguments + " --ranks >.out 2>.err";
        const pid_t child = ::fork();
        if (child == 0) {
            ::setenv("XDG_CACHE_HOME", (folder_ / "cache").c_str(), 1);
            ::setenv("XDG_CONFIG_HOME", (folder_ / "config").c_str(), 1);
            ::execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
            ::_exit(127);
        }
        return child;
    }
    double differenceOf(const std::string& a, const std::string& b) const {
        const Image x = readImage(folder_ / a), y = readImage(folder_ / b);
        EXPECT_EQ(x.size, y.size);
        double largest = 0;
        for (std::size_t i = 0; i < std::min(x.pixels.size(), y.pixels.size()); ++i)
            for (int c = 0; c < 4; ++c) {
                const double difference = std::abs(static_cast<double>(x.pixels[i][c]) - y.pixels[i][c]);
                largest = difference <= largest ? largest : difference;
            }
        return largest;
    }
    /// Children of a process that are tessera.
    static std::vector<pid_t> ranksOf(pid_t mpirun) {
        std::vector<pid_t> all;
        std::istringstream children(
            readAll("/proc/" + std::to_string(mpirun) + "/task/" + std::to_string(mpirun) + "/children"));
        for (pid_t child = 0; children >> child;)
            all.push_back(child);
        return all;
    }
    std::vector<std::string> namesLike(const std::string& part) const {
        std::vector<std::string> names;
        for (const auto& entry : fs::directory_iterator(folder_.path()))
            if (const std::string name = entry.path().filename(); name.find(part) != std::string::npos)
                names.push_back(name);
        return names;
    }
    static constexpr const char* kExact = " --set quality.terminationTransmittance=0 ";
};

TEST_F(RankedPictures, EqualThoseOfOne) {
    write(
        "inside.json",
        R"({"tesseraScene":1,"volumes":[{"path":"v.zarr"}],"lighting":{"occlusion":{}},"camera":{"position":[3,-4,2],
        "focalPoint":[-30,40,12],"viewUp":[0,0,1],"viewAngle":100}})");
    for (const std::string& options :
         {std::string("v.zarr --view 35,20 --samples 1 --step 0.5 --preset soft-tissue"),
          std::string("v.zarr --view left --projection parallel --samples 1 --step 0.5"),
          std::string("inside.json --samples 1 --step 0.7"),
          std::string("v.zarr --view 200,-40 --fit volume"), std::string("s.zarr --samples 2 --step 1")}) {
        const std::string all = "render " + options + kExact + "--size 90x70 -q ";
        const Outcome one = run(all + "-o one.exr --engine native --verify none");
        ASSERT_EQ(one.exitCode, 0) << options << one.problems;
        for (const int count : {2, options[0] == 's' ? 6 : 4}) {
            const Outcome shared = runRanks(count, all + "-o all.exr");
            ASSERT_EQ(shared.exitCode, 0) << options << shared.problems;
            EXPECT_EQ(shared.problems, "");
            EXPECT_LE(differenceOf("all.exr", "one.exr"), 1e-5) << options << ", of " << count;
            const json ranks = json::parse(readManifest(folder_ / "all.exr"))["ranks"];
            ASSERT_EQ(std::ssize(ranks), count);
            for (const json& rank : ranks)
                EXPECT_EQ(rank["bytesOfBricks"] == 0, rank["bricks"][0] == rank["bricks"][1]) << rank;
        }
    }
}

TEST_F(RankedPictures, AreSaidOnce) {
    const Outcome outcome = runRanks(3, "render v.zarr -o a.png --size 64x64 --json");
    EXPECT_EQ(outcome.exitCode, 0) << outcome.problems;
    EXPECT_EQ(std::ssize(json::parse(outcome.out)["ranks"]), 3);
    const std::size_t wrote = outcome.problems.find("wrote a.png");
    EXPECT_NE(wrote, std::string::npos) << outcome.problems;
    EXPECT_EQ(outcome.problems.find("wrote a.png", wrote + 1), std::string::npos) << outcome.problems;
}

TEST_F(RankedPictures, EndWithAProcessThatIsKilled) {
    const std::string drawing = "render v.zarr -q --size 900x900 --samples 16 --step 0.25 -o a.exr";
    ASSERT_EQ(run("render v.zarr -q --size 32x32 -o a.exr").exitCode, 0);
    const std::string before = readAll(folder_ / "a.exr");
    std::mt19937 random(3);
    for (int round = 0; round < 3; ++round) {
        const pid_t all = startRanks(3, drawing);
        std::this_thread::sleep_for(
            std::chrono::milliseconds(std::uniform_int_distribution<int>(300, 1200)(random)));
        const std::vector<pid_t> ranks = ranksOf(all);
        ASSERT_FALSE(ranks.empty());
        ::kill(ranks[static_cast<std::size_t>(round) % ranks.size()], SIGKILL);
        int status = 0;
        ::waitpid(all, &status, 0);
        EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) != 0) << status;
        EXPECT_EQ(readAll(folder_ / "a.exr"), before) << "round " << round;
    }
    ASSERT_EQ(runRanks(2, "render v.zarr -q --size 32x32 -o a.exr").exitCode, 0);
    EXPECT_THAT(namesLike("a.exr"), ::testing::ElementsAre("a.exr")) << "leftovers stayed";
}

TEST_F(RankedPictures, EndWithAProcessThatFails) {
    // A shard of the finest level that is cut short: only who draws its bricks reads it.
    for (const auto& entry : fs::recursive_directory_iterator(folder_ / "v.zarr"))
        if (entry.is_regular_file() && entry.path().string().find("/0/c/") != std::string::npos)
            fs::resize_file(entry.path(), fs::file_size(entry.path()) / 2);
    const Outcome outcome = runRanks(3, "render v.zarr -q --size 64x64 -o a.exr");
    EXPECT_NE(outcome.exitCode, 0);
    EXPECT_THAT(outcome.problems, HasSubstr("tessera: "));
    EXPECT_THAT(namesLike("a.exr"), ::testing::IsEmpty());
}

TEST_F(RankedPictures, RefuseWhatCrossesTheVolume) {
    for (const auto& [options, words] : std::vector<std::pair<std::string, std::string>>{
             {"--mode maximum", "expected mode composite"},
             {"--isosurface 300", "expected mode composite without isosurfaces"},
             {"--light dramatic", "expected lights without shadows"},
             {"--engine mirror", "expected native with --ranks"},
             {"--tiles 64", "expected no --tiles with it"},
             {"--max-error 2", "expected no error bound"},
             {"--verify full", "expected --verify none"}}) {
        const Outcome outcome = runRanks(2, "render v.zarr -q --size 64x64 -o a.exr " + options);
        EXPECT_EQ(outcome.exitCode, 2) << options;
        EXPECT_THAT(outcome.problems, HasSubstr(words)) << options;
        EXPECT_THAT(namesLike("a.exr"), ::testing::IsEmpty());
    }
}

} // namespace
} // namespace tessera::test
