// tests/program/tiles_test.cpp: one picture in tiles, by the program: equal to the picture as a whole,
// however many processes draw it and whichever is killed; what is refused, and tiles that are not what was
// written.
#include "tests/support/program_fixture.h"

#include "core/base/progress.h"
#include "core/image/image_file.h"
#include "viewer/tiles/tile_file.h"
#include "viewer/tiles/tile_folder.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstring>
#include <dirent.h>
#include <dlfcn.h>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <thread>

namespace {
std::atomic<std::size_t> entriesRead{0}; // of folders
} // namespace

// In place of the C library's, in this program. No test waits for a disk.
extern "C" int fsync(int) {
    return 0;
}
extern "C" dirent* readdir(DIR* folder) {
    static const auto real = reinterpret_cast<dirent* (*)(DIR*)>(::dlsym(RTLD_NEXT, "readdir"));
    ++entriesRead;
    return real(folder);
}

namespace tessera::test {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using Clock = std::chrono::steady_clock;

class TiledPictures : public Program {
  protected:
    void SetUp() override { makeSphere(); }
    static std::string drawing(const std::string& out, const std::string& more) {
        return "render s.zarr -q --engine native -o " + out + " " + more + " ";
    }
    void expectSamePicture(const std::string& a, const std::string& b, const std::string& what) const {
        const Image x = readImage(folder_ / a), y = readImage(folder_ / b);
        ASSERT_EQ(x.size, y.size) << what;
        EXPECT_EQ(std::memcmp(x.pixels.data(), y.pixels.data(), x.pixels.size() * sizeof(glm::vec4)), 0)
            << what;
    }
    std::vector<fs::path> tilesOf(const std::string& out) const {
        std::vector<fs::path> all;
        std::error_code ignored;
        for (const auto& entry : fs::directory_iterator(folder_ / (out + ".tiles"), ignored))
            if (entry.path().extension() == ".tile")
                all.push_back(entry.path());
        std::sort(all.begin(), all.end());
        return all;
    }
    /// What is in the folder of tiles.
    std::vector<std::string> left(const std::string& out) const {
        std::vector<std::string> all;
        std::error_code ignored;
        for (const auto& entry : fs::directory_iterator(folder_ / (out + ".tiles"), ignored))
            all.push_back(entry.path().filename());
        return all;
    }
    /// Draws some tiles, and is killed.
    void beginAndKill(const std::string& arguments, const std::string& out, std::size_t tiles) {
        const pid_t child = start(arguments);
        const auto end = Clock::now() + std::chrono::seconds(60);
        while (tilesOf(out).size() < tiles && Clock::now() < end)
            ::usleep(200);
        ::kill(child, SIGKILL);
        ::waitpid(child, nullptr, 0);
        ASSERT_GE(tilesOf(out).size(), tiles);
    }
};

TEST_F(TiledPictures, EqualTheWhole) {
    const std::string small = "--size 150x110 --preset bone --samples 2 ";
    for (const auto& [name, options] :
         std::map<std::string, std::string>{{"a.png", "--background black"},
                                            {"b.exr", "--view 30,20"},
                                            {"c.tif", "--projection parallel --pixel-filter gaussian"},
                                            {"d.png", "--mode isosurface --isosurface 0 --light soft"},
                                            {"e.exr", "--mode maximum"}}) {
        const std::string extension = fs::path(name).extension();
        ASSERT_EQ(run(drawing("whole" + extension, small + options)).exitCode, 0) << options;
        const Outcome tiled = run(drawing(name, small + options + " --tiles 64"));
        ASSERT_EQ(tiled.exitCode, 0) << options << tiled.problems;
        expectSamePicture(name, "whole" + extension, options);
        EXPECT_FALSE(exists(name + ".tiles"));
        json a = json::parse(readManifest(folder_ / name)),
             b = json::parse(readManifest(folder_ / ("whole" + extension)));
        EXPECT_EQ(a["tiles"]["tiles"], 6);
        EXPECT_EQ(a["tiles"]["drawn"], 6);
        EXPECT_EQ(a["errors"]["measured"], b["errors"]["measured"]) << "the error is that of the whole";
        EXPECT_EQ(a["pixels"], b["pixels"]);
        EXPECT_GT(b["errors"]["measured"]["pixels"], 300);
        EXPECT_EQ(a["scene"], b["scene"]);
    }
}

#if TESSERA_WITH_ANNOTATIONS
// What is said over a picture is laid out for the whole of it.
TEST_F(TiledPictures, HaveTheAnnotationsOfTheWhole) {
    const std::string picture =
        "--size 300x700 --preset auto --samples 1 --dpi 200 --scale-bar --directions all "
        "--legend --title A_title --caption words --error-caption ";
    for (const std::string extension : {".png", ".tif", ".exr"})
        for (const std::string background : {"--background white", "--background transparent"}) {
            const std::string options = picture + background, whole = "whole" + extension,
                              name = "a" + extension;
            ASSERT_EQ(run(drawing(whole, options)).exitCode, 0) << options;
            const Outcome tiled = run(drawing(name, options + " --tiles 64"));
            ASSERT_EQ(tiled.exitCode, 0) << options << tiled.problems;
            expectSamePicture(name, whole, options);
            const json a = json::parse(readManifest(folder_ / name)),
                       b = json::parse(readManifest(folder_ / whole));
            for (const char* key : {"annotations", "legend", "scaleBar", "scene"})
                EXPECT_EQ(a[key], b[key]) << key;
            const std::string bytes = readAll(folder_ / name), others = readAll(folder_ / whole);
            if (extension != ".exr") {
                const std::string dpi = extension == ".png" ? "pHYs" : "";
                EXPECT_EQ(bytes.substr(bytes.find(dpi), 13), others.substr(others.find(dpi), 13));
                continue;
            }
            EXPECT_THAT(bytes, HasSubstr(std::string("annotations.A") + '\0'));
            constexpr std::size_t kEnd = 20000; // of the lines, behind manifests that differ
            ASSERT_GT(std::min(bytes.size(), others.size()), 2 * kEnd);
            EXPECT_EQ(bytes.substr(bytes.size() - kEnd), others.substr(others.size() - kEnd));
            EXPECT_EQ(run("redraw " + name).exitCode, 0);
        }
}
#endif

TEST_F(TiledPictures, AreDrawnByTwoAndFourAndOneIsKilled) {
    const std::string picture = "--size 700x500 --tiles 64 --preset bone --samples 4";
    const auto began = Clock::now();
    ASSERT_EQ(run(drawing("whole.exr", "--size 700x500 --preset bone --samples 4")).exitCode, 0);
    const std::chrono::duration<double> whole = Clock::now() - began;
    std::mt19937 random(11);
    int killed = 0, shared = 0, leftovers = 0;
    for (int round = 0; round < 8; ++round) {
        const std::size_t count = round % 2 == 0 ? 2 : 4;
        std::vector<pid_t> children;
        for (std::size_t n = 0; n < count; ++n)
            children.push_back(start(drawing("a.exr", picture)));
        std::this_thread::sleep_for(whole * std::uniform_real_distribution<double>(0.1, 1.5)(random));
        ::kill(children[0], SIGKILL);
        for (std::size_t n = 0; n < count; ++n) {
            int status = 0;
            ::waitpid(children[n], &status, 0);
            if (n == 0)
                killed += WIFSIGNALED(status);
            else
                EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << readAll(folder_ / ".err");
        }
        expectSamePicture("a.exr", "whole.exr", "round " + std::to_string(round));
        const json tiles = json::parse(readManifest(folder_ / "a.exr"))["tiles"];
        shared += tiles["drawn"] < tiles["tiles"] ? 1 : 0;
        if (exists(
                "a.exr.tiles")) { // it was killed when the others had gone: the rest goes with the next run
            ++leftovers;
            EXPECT_EQ(run(drawing("a.exr", picture)).exitCode, 0);
        }
        EXPECT_THAT(left("a.exr"), ::testing::IsEmpty()) << "round " << round;
        EXPECT_FALSE(exists("a.exr.tiles")) << "round " << round;
        fs::remove(folder_ / "a.exr");
    }
    EXPECT_GT(killed, 1);
    EXPECT_LT(leftovers, 3);
    EXPECT_GT(shared, 1) << "no tiles but one process's";
}

TEST_F(TiledPictures, GoOnWhereTheyStoppedAndDrawDamagedTilesAgain) {
    const std::string picture = "--size 600x500 --preset bone --samples 2 ";
    ASSERT_EQ(run(drawing("whole.exr", picture)).exitCode, 0);
    beginAndKill(drawing("a.exr", picture + "--tiles 64"), "a.exr", 4);
    const std::vector<fs::path> tiles = tilesOf("a.exr");
    std::string bytes = readAll(tiles[0]);
    bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 4);
    std::ofstream(tiles[0], std::ios::binary) << bytes;
    fs::resize_file(tiles[1], fs::file_size(tiles[1]) - 16);
    std::ofstream(tiles[2]) << "a file of the user's";
    const fs::path folder = tiles[0].parent_path();
    std::ofstream(folder / ".tile-000000.tile.claim") << "";
    std::ofstream(folder / ".plan-1-0.json") << "killed before it was the plan";
    const Outcome outcome = run("render s.zarr --engine native -o a.exr --tiles 64 " + picture);
    ASSERT_EQ(outcome.exitCode, 0) << outcome.problems;
    EXPECT_THAT(outcome.problems,
                HasSubstr(tiles[0].filename().string() + ": expected a tile of this picture, found a "
                                                         "damaged tile"));
    EXPECT_THAT(outcome.problems,
                HasSubstr(tiles[1].filename().string() + ": expected a tile of this picture, found a "
                                                         "file of "));
    EXPECT_THAT(outcome.problems, HasSubstr(tiles[2].filename().string()));
    expectSamePicture("a.exr", "whole.exr", "again");
    const json report = json::parse(readManifest(folder_ / "a.exr"))["tiles"];
    EXPECT_EQ(report["there"], tiles.size());
    EXPECT_EQ(report["drawnAgain"], 3);
    EXPECT_FALSE(exists("a.exr.tiles"));
}

TEST_F(TiledPictures, OfOthersAreRefused) {
    const std::string picture = "--size 600x500 --preset bone --samples 2 ";
    beginAndKill(drawing("a.exr", picture + "--tiles 64 --step 0.5"), "a.exr", 1);
    for (const auto& [options, words] : std::map<std::string, std::vector<std::string>>{
             {"--tiles 64 --step 0.25", {"a.exr.tiles", "scene.quality.stepVoxels: 0.25", "0.5"}},
             {"--tiles 96 --step 0.5", {"a.exr.tiles", "tile: 96", "64"}},
             {"--tiles 64 --step 0.5 --view left", {"a.exr.tiles", "scene.camera"}}})
        expectRefused(drawing("a.exr", picture + options), words);
    // Another plan, with all options alike.
    const fs::path plan = folder_ / "a.exr.tiles/plan.json";
    json other = json::parse(readAll(plan));
    other["integrator"] = "another";
    std::ofstream(plan) << other.dump();
    expectRefused(
        drawing("a.exr", picture + "--tiles 64 --step 0.5"),
        {"a.exr.tiles", "tiles of this picture (integrator: ", "those of another (\"another\")", "--ram"});
    std::ofstream(folder_ / "a.exr.tiles/tiles.json") << "no json";
    expectRefused(drawing("a.exr", picture + "--tiles 64 --step 0.5"), {"tiles.json", "something else"});
}

TEST_F(TiledPictures, LeaveNothingWhereNoTileWasDrawn) {
    expectRefused(drawing("a.exr", "--size 600x500 --tiles 512 --ram 4MiB"), {"--ram"});
    expectRefused(drawing("a.exr", "--size 600x500 --tiles 64 --gpu-memory 100KiB"), {"--gpu-memory"});
    EXPECT_FALSE(exists("a.exr.tiles"));
}

TEST_F(TiledPictures, WhatNeedsAllPixelsIsRefused) {
    const std::string tiled = "render s.zarr -q --engine native -o a.exr --size 100x100 --tiles 64 ";
    for (const auto& [options, words] : std::map<std::string, std::vector<std::string>>{
             {"--samples auto", {"--tiles", "--samples auto"}},
             {"--samples 8 --noise 0.1", {"--tiles", "--noise"}},
             {"--light cinematic --denoise", {"--tiles", "--denoise"}},
             {"--samples 2 --max-error 1", {"--tiles", "--max-error"}},
             {"--first b.png", {"--tiles", "--first"}},
             {"--light cinematic --layers all", {"--tiles", "--layers"}},
             {"--light cinematic --keep-state k", {"--tiles", "--keep-state"}}})
        expectRefused(tiled + options, words);
    expectRefused("render s.zarr --turn 360 -o f --tiles 64", {"--tiles", "a film"});
    for (const char* side : {"63", "16385", "100.5", "x"})
        expectRefused("render s.zarr -o a.exr --tiles " + std::string(side), {"--tiles"});
    const Outcome unnamed = run("render s.zarr --engine native -o a.exr --size 100x100 --tiles 64");
    EXPECT_EQ(unnamed.exitCode, 0);
    EXPECT_THAT(unnamed.problems, HasSubstr("--tiles: one ray per pixel"));
    EXPECT_EQ(json::parse(readManifest(folder_ / "a.exr"))["pixels"]["samples"], 1);
}

// Tiles of one folder by two that have it open.

TEST(TileFolders, AreFinishedByOne) {
    const ScratchFolder scratch;
    Progress progress;
    const auto say = [](const std::string& words) { ADD_FAILURE() << words; };
    const json record = {{"a", 1}};
    TileFolder a(scratch / "t", record, {150, 70}, 64, progress, say);
    TileFolder b(scratch / "t", record, {150, 70}, 64, progress, say);
    a.begin({{"step", "1"}});
    b.begin({{"step", "1"}});
    const auto grey = [](const PictureTile& tile) {
        Image image(tile.size);
        std::fill(image.pixels.begin(), image.pixels.end(), glm::vec4(0.25f, 0.25f, 0.25f, 0.5f));
        return image;
    };
    const auto held = b.next(); // a draws all but this
    ASSERT_TRUE(held);
    for (int n = 0; n < 5; ++n) {
        const auto tile = a.next();
        ASSERT_TRUE(tile);
        EXPECT_NE(*tile, *held);
        a.keep({*tile, grey(*tile), {}, {}});
    }
    EXPECT_EQ(a.share(), 5.0 / 6);
    b.keep({*held, grey(*held), {}, {}});
    EXPECT_FALSE(a.next());
    ASSERT_TRUE(a.finishes());
    EXPECT_EQ(a.shown(), 150u * 70);
    EXPECT_EQ(a.report().byOthers, 1u);
    std::size_t pixels = 0;
    a.eachPixel([&](const glm::vec4& colour, const glm::vec4& offset) {
        pixels += colour == glm::vec4(0.25f, 0.25f, 0.25f, 0.5f) && offset == glm::vec4(0) ? 1 : 0;
    });
    EXPECT_EQ(pixels, 150u * 70);
    EXPECT_FALSE(a.rows({}).opaque);
    EXPECT_TRUE(a.rows(glm::vec3(0, 0, 1)).opaque);
    EXPECT_EQ(a.rows(glm::vec3(0, 0, 1)).rows(69, 1)[149], glm::vec4(0.25f, 0.25f, 0.75f, 1));
    std::thread other([&] {
        EXPECT_FALSE(b.next());
        EXPECT_FALSE(b.finishes());
        b.finish();
    });
    a.finish();
    other.join();
    EXPECT_FALSE(fs::exists(scratch / "t"));
}

TEST(TileFolders, ALateOneHidesNoEndFromThoseWhoWait) {
    const ScratchFolder scratch;
    Progress progress;
    const auto say = [](const std::string& words) { ADD_FAILURE() << words; };
    const json record = {{"a", 1}};
    TileFolder a(scratch / "t", record, {64, 64}, 64, progress, say);
    TileFolder b(scratch / "t", record, {64, 64}, 64, progress, say);
    a.begin({});
    b.begin({});
    const auto tile = a.next();
    ASSERT_TRUE(tile);
    a.keep({*tile, Image(tile->size), {}, {}});
    ASSERT_FALSE(a.next());
    ASSERT_TRUE(a.finishes());
    std::thread ending([&] { a.finish(); }); // waits a while for b to go
    while (!fs::exists(scratch / "t/finished-0"))
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    TileFolder late(scratch / "t", record, {64, 64}, 64, progress, say);
    EXPECT_FALSE(b.next());
    EXPECT_FALSE(b.finishes()) << "the picture was written";
    b.finish();
    late.begin({});
    EXPECT_FALSE(late.next());
    EXPECT_TRUE(late.finishes()) << "it is wanted again";
    late.finish();
    ending.join();
    EXPECT_FALSE(fs::exists(scratch / "t"));
}

TEST(TileFolders, ManyTilesDoNotTakeTheirSquare) {
    const ScratchFolder scratch;
    Progress progress;
    TileFolder tiles(scratch / "t", json{{"a", 1}}, {80, 60}, 4, progress,
                     [](const std::string& words) { ADD_FAILURE() << words; });
    tiles.begin({});
    const std::size_t before = entriesRead;
    std::size_t count = 0;
    while (const auto tile = tiles.next()) {
        tiles.keep({*tile, Image(tile->size), {}, {}});
        ++count;
    }
    EXPECT_EQ(count, 300u);
    EXPECT_LT(entriesRead - before, 20 * count) << "the folder is read for every tile";
    tiles.finish();
    EXPECT_FALSE(fs::exists(scratch / "t"));
}

// Files of tiles.

Image randomTile(const glm::ivec2& size, std::uint32_t seed) {
    Image image(size);
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> uniform(0, 1);
    for (glm::vec4& p : image.pixels)
        p = {uniform(random), uniform(random), uniform(random), uniform(random)};
    return image;
}

class TileFiles : public ::testing::Test {
  protected:
    const ScratchFolder folder_;
    const fs::path path_ = folder_ / "tile-000001.tile";
    const PictureTile tile_{{64, 0}, {5, 3}};
    const std::string key_ = "0123456789abcdef";
    std::string wrong(const PictureTile& tile, const std::string& key) const {
        std::string why;
        const auto file = TileFile::open(path_, tile, key, why);
        return file ? file->damage() : why;
    }
};

TEST_F(TileFiles, KeepEveryBit) {
    const Image colours = randomTile(tile_.size, 1), added = randomTile(tile_.size, 2),
                offsets = randomTile(tile_.size, 5);
    for (const bool lit : {false, true}) {
        writeTile(path_, {tile_, colours, lit ? added : Image(), lit ? Image() : offsets}, key_);
        std::string why;
        const auto file = TileFile::open(path_, tile_, key_, why);
        ASSERT_TRUE(file) << why;
        EXPECT_EQ(file->damage(), "");
        EXPECT_EQ(file->facts().tile, tile_);
        EXPECT_FALSE(file->facts().opaque || file->facts().blank);
        EXPECT_EQ(file->facts().shown, 15u);
        std::vector<glm::vec4> row(5), bare(5), off(5);
        for (int y = 0; y < 3; ++y) {
            file->readRow(y, row);
            file->readRow(y, bare, off);
            for (int x = 0; x < 5; ++x) {
                EXPECT_EQ(file->colour({x, y}), colours.at(x, y));
                EXPECT_EQ(bare[static_cast<std::size_t>(x)], colours.at(x, y));
                EXPECT_EQ(off[static_cast<std::size_t>(x)], lit ? glm::vec4(0) : offsets.at(x, y));
                EXPECT_EQ(row[static_cast<std::size_t>(x)],
                          colours.at(x, y) + (lit ? added.at(x, y) : glm::vec4(0)));
            }
        }
    }
    Image full = colours;
    for (glm::vec4& p : full.pixels)
        p.a = 1;
    writeTile(path_, {tile_, full, {}, {}}, key_);
    std::string why;
    EXPECT_TRUE(TileFile::open(path_, tile_, key_, why)->facts().opaque);
    writeTile(path_, {tile_, Image(tile_.size), {}, {}}, key_);
    EXPECT_TRUE(TileFile::open(path_, tile_, key_, why)->facts().blank);
    EXPECT_EQ(TileFile::open(path_, tile_, key_, why)->facts().shown, 0u);
}

TEST_F(TileFiles, TellEveryDamage) {
    const PictureTile tile{{64, 0}, {3, 2}};
    writeTile(path_, {tile, randomTile(tile.size, 3), randomTile(tile.size, 4), randomTile(tile.size, 6)},
              key_);
    const std::string whole = readAll(path_);
    ASSERT_EQ(wrong(tile, key_), "");
    for (std::size_t n = 0; n < whole.size(); ++n) {
        std::string bytes = whole;
        bytes[n] = static_cast<char>(bytes[n] ^ (1 << n % 8));
        std::ofstream(path_, std::ios::binary) << bytes;
        EXPECT_NE(wrong(tile, key_), "") << "byte " << n;
        std::ofstream(path_, std::ios::binary) << whole.substr(0, n);
        EXPECT_NE(wrong(tile, key_), "") << n << " bytes";
    }
    std::ofstream(path_, std::ios::binary) << whole + "x";
    EXPECT_NE(wrong(tile, key_), "");
    std::ofstream(path_, std::ios::binary) << whole;
    EXPECT_EQ(wrong(tile, "0123456789abcdeF"), "a tile of another picture");
    EXPECT_EQ(wrong({{0, 0}, {5, 3}}, key_), "another tile");
    fs::remove(path_);
    EXPECT_EQ(wrong(tile, key_), "no file that can be read");
    fs::create_directory(path_);
    EXPECT_EQ(wrong(tile, key_), "no file that can be read");
}

} // namespace
} // namespace tessera::test
