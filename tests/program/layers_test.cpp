// tests/program/layers_test.cpp: layers in a picture's file, and pictures that go on from kept samples, from
// outside.
#include "tests/support/program_fixture.h"

#include "core/image/image_file.h"

#include <csignal>
#include <nlohmann/json.hpp>
#include <thread>

namespace tessera::test {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

class Layers : public Program {
  protected:
    void SetUp() override { makeSphere(); }
    /// A small picture by paths of light.
    Outcome draw(const std::string& out, const std::string& options) {
        return run("render s.zarr -o " + out + " " + kPaths + " " + options);
    }
    void expectDrawn(const std::string& out, const std::string& options) {
        const Outcome outcome = draw(out, options + " -q");
        ASSERT_EQ(outcome.exitCode, 0) << options << "\n" << outcome.problems;
    }
    void expectSamePicture(const std::string& a, const std::string& b) {
        const Image first = readImage(folder_ / a), second = readImage(folder_ / b);
        EXPECT_EQ(first.pixels, second.pixels) << a << " " << b;
    }
    void refused(const std::string& options, const std::vector<std::string>& words) {
        expectRefused("render s.zarr " + options, words);
    }
    const std::string kPaths = "--preset auto --light cinematic --size 24x20 --no-check";
};

TEST_F(Layers, AreToldInTheManifestAndReadAsAPicture) {
    expectDrawn("a.exr", "--samples 4 --layers depth,error --layers albedo");
    expectDrawn("b.exr", "--samples 4 --background transparent");
    expectSamePicture("a.exr", "b.exr");
    const json manifest = json::parse(readManifest(folder_ / "a.exr"));
    EXPECT_EQ(manifest["layers"], json({"albedo", "depth", "error"}));
    EXPECT_EQ(manifest["scene"]["image"]["background"], "transparent");
    const std::string bytes = readAll(folder_ / "a.exr");
    for (const std::string channel : {"albedo.R", "albedo.B", "depth.Z", "error.A"})
        EXPECT_THAT(bytes, HasSubstr(channel + '\0'));
    EXPECT_THAT(bytes, Not(HasSubstr("normal.X")));
    EXPECT_FALSE(json::parse(readManifest(folder_ / "b.exr")).contains("layers"));
    EXPECT_EQ(run("info a.exr").exitCode, 0);
    // All that a scene has: without paths the error, of pixels with a number of samples.
    ASSERT_EQ(run("render s.zarr -o c.exr --preset auto --size 16x16 --samples 4 --layers all -q").exitCode,
              0);
    EXPECT_EQ(json::parse(readManifest(folder_ / "c.exr"))["layers"], json({"error"}));
}

TEST_F(Layers, AreRefusedWhereThereAreNone) {
    refused("-o a.png " + kPaths + " --layers all", {"--layers", ".exr", "a.png"});
    refused("-o a.exr " + kPaths + " --layers colour", {"--layers", "albedo", "\"colour\""});
    refused("-o a.exr --layers normal", {"--layers", "--light cinematic"});
    refused("-o a.exr --layers all", {"--layers", "--samples", "without layers"});
    refused("-o a.exr --samples 1 --layers error", {"--layers", "samples from 2 on", "found 1"});
    refused("-o a.exr --layers error", {"--layers", "samples from 2 on", "auto"});
    refused("-o a.exr " + kPaths + " --background red --layers all", {"--background", "transparent"});
    refused("-o film/ " + kPaths + " --turn 360 --layers all", {"--layers", "one picture"});
}

TEST_F(Layers, KeptSamplesGoOn) {
    expectDrawn("whole.exr", "--samples 32 --layers all");
    expectDrawn("first.exr", "--samples 8 --layers all --keep-state kept");
    const Outcome outcome = draw("rest.exr", "--samples 32 --layers all --keep-state kept --json");
    ASSERT_EQ(outcome.exitCode, 0) << outcome.problems;
    EXPECT_THAT(outcome.problems, HasSubstr("went on from 8 samples a pixel of kept"));
    EXPECT_EQ(json::parse(outcome.out)["pixels"]["samplesOfEarlierRuns"], 8);
    EXPECT_EQ(json::parse(outcome.out)["pixels"]["samplesTaken"], 32);
    expectSamePicture("rest.exr", "whole.exr");
    EXPECT_THAT(readAll(folder_ / "kept"), Not(HasSubstr("s.zarr"))) << "no names of files";
    // Another scene, another volume.
    ASSERT_EQ(run("phantom sphere --size 40x33x25 -o other.zarr").exitCode, 0);
    const std::string on = kPaths + " --samples 32 --keep-state kept";
    refused("-o a.exr " + on, {"kept", "with layers of paths false", "found true"});
    refused("-o a.exr " + on + " --layers all --seed 4", {"kept", "quality.seed 4"});
    refused("-o a.exr " + on + " --layers all --set lighting.transport.bounces=2",
            {"kept", "lighting.transport.bounces 2", "found 16"});
    expectRefused("render other.zarr -o a.exr " + on + " --layers all", {"kept", "volumes[0].path"});
}

TEST_F(Layers, KeptSamplesAreRefusedWhereThereAreNone) {
    refused("-o a.exr --samples 4 --keep-state k", {"--keep-state", "--light cinematic"});
    refused("-o a.exr " + kPaths + " --samples 1 --keep-state k", {"--keep-state", "from 2 on", "found 1"});
    refused("-o a.exr " + kPaths + " --mode maximum --samples 4 --keep-state k",
            {"--keep-state", "paths of light"});
    refused("-o k " + kPaths + " --keep-state k", {"k"});
    refused("-o k.png " + kPaths + " --keep-state k.png", {"--keep-state", "another file"});
    refused("-o film/ " + kPaths + " --turn 360 --keep-state k", {"--keep-state", "one picture"});
    refused("-o a.png " + kPaths + " --keep-state missing/k", {"missing"});
    write("k", "a letter");
    refused("-o a.png " + kPaths + " --keep-state k", {"k: expected samples that --keep-state kept"});
    EXPECT_EQ(readAll(folder_ / "k"), "a letter");
}

/// Ctrl-C leaves the rounds that were whole.
TEST_F(Layers, AnInterruptedPictureGoesOn) {
    const std::string command = "--samples 16384 --keep-state kept";
    const pid_t child = ::fork();
    if (child == 0) {
        std::vector<std::string> words = {"tessera", "render", "s.zarr", "-o", "a.exr", "-q"};
        std::istringstream text(kPaths + " " + command);
        for (std::string word; text >> word;)
            words.push_back(word);
        ::_exit(runInChild(words));
    }
    for (int n = 0; n < 2000 && !exists("kept"); ++n)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    ASSERT_TRUE(exists("kept"));
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    ::kill(child, SIGINT);
    int status = 0;
    ::waitpid(child, &status, 0);
    ASSERT_TRUE(WIFEXITED(status));
    ASSERT_EQ(WEXITSTATUS(status), 130) << "it was done before";
    EXPECT_FALSE(exists("a.exr"));
    const Outcome outcome = draw("b.exr", "--samples 16384 --noise 0.9 --keep-state kept");
    ASSERT_EQ(outcome.exitCode, 0) << outcome.problems;
    EXPECT_THAT(outcome.problems, HasSubstr("went on from "));
    const json manifest = json::parse(readManifest(folder_ / "b.exr"));
    const int samples = manifest["pixels"]["samplesOfEarlierRuns"];
    expectDrawn("whole.exr",
                "--samples " + std::to_string(static_cast<int>(manifest["pixels"]["samplesTaken"])));
    EXPECT_GE(samples, 2);
    expectSamePicture("b.exr", "whole.exr");
}

} // namespace
} // namespace tessera::test
