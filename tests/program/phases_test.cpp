// tests/program/phases_test.cpp: files of several times: the choice of one, and films over all; and pictures
// along lines by the program.
#include "tests/support/program_fixture.h"

#include "core/image/image_file.h"
#include "core/scene/annotations.h"

#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>

namespace tessera::test {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

/// A ball that grows, HU: at time t of n its radius is 4 + 2t voxels, of 20 x 18 x 16 voxels of 2 mm.
constexpr int kNx = 20, kNy = 18, kNz = 16;
std::int16_t valueAt(int x, int y, int z, int time) {
    const double dx = x - 9.5, dy = y - 8.5, dz = z - 7.5, radius = 3 + 1.5 * time;
    return static_cast<std::int16_t>(dx * dx + dy * dy + dz * dz < radius * radius ? 100 * (time + 1)
                                                                                   : -1000);
}
std::string voxelsOf(int time, int slices = kNz) {
    std::string bytes;
    for (int z = 0; z < slices; ++z)
        for (int y = 0; y < kNy; ++y)
            for (int x = 0; x < kNx; ++x) {
                const std::int16_t value = valueAt(x, y, z, time);
                bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
            }
    return bytes;
}

template <typename T> void put(std::string& bytes, std::size_t at, T value) {
    std::memcpy(bytes.data() + at, &value, sizeof value);
}
std::string niftiOf(int times, int slices = kNz) {
    std::string file(352, '\0');
    put<std::int32_t>(file, 0, 348);
    const std::int16_t dims[] = {static_cast<std::int16_t>(times > 1 ? 4 : 3),
                                 kNx,
                                 kNy,
                                 static_cast<std::int16_t>(slices),
                                 static_cast<std::int16_t>(times),
                                 1,
                                 1,
                                 1};
    std::memcpy(file.data() + 40, dims, sizeof dims);
    put<std::int16_t>(file, 70, 4); // 16 bits, signed
    put<std::int16_t>(file, 72, 16);
    const float pixdim[] = {1, 2, 2, 2, 2.5F, 0, 0, 0};
    std::memcpy(file.data() + 76, pixdim, sizeof pixdim);
    put<float>(file, 108, 352);
    file[123] = 2 + 8; // mm, s
    std::memcpy(file.data() + 344, "n+1", 4);
    for (int time = 0; time < times; ++time)
        file += voxelsOf(time, slices);
    return file;
}
/// Layers behind one another, or of every voxel together.
std::string nrrdOf(int times, bool isInterleaved) {
    const std::string space = "20 18 16", many = std::to_string(times);
    std::string file = "NRRD0004\ntype: short\ndimension: 4\nspace: left-posterior-superior\nsizes: " +
                       (isInterleaved ? many + " " + space : space + " " + many) +
                       "\nspace directions: " + (isInterleaved ? "none " : "") + "(2,0,0) (0,2,0) (0,0,2)" +
                       (isInterleaved ? "" : " none") + "\nkinds: " + (isInterleaved ? "list " : "") +
                       "domain domain domain" + (isInterleaved ? "" : " time") +
                       "\nendian: little\nencoding: raw\n\n";
    std::vector<std::string> all;
    for (int time = 0; time < times; ++time)
        all.push_back(voxelsOf(time));
    if (!isInterleaved)
        for (const std::string& one : all)
            file += one;
    else
        for (std::size_t at = 0; at < all[0].size(); at += 2)
            for (const std::string& one : all)
                file += one.substr(at, 2);
    return file;
}

class Phases : public Program {
  protected:
    json manifestOf(const std::string& picture) const { return json::parse(readManifest(folder_ / picture)); }
    std::string pixelsOf(const std::string& picture) const {
        const std::string bytes = readAll(folder_ / picture);
        return bytes.substr(std::min(bytes.size(), bytes.find("IDAT")));
    }
    /// The content of the store that an import of a phase makes.
    std::string contentOf(const std::string& file, const std::string& options) {
        const Outcome made = run("import " + file + " one.zarr --force --unit HU " + options);
        EXPECT_EQ(made.exitCode, 0) << made.problems;
        const Outcome info = run("info one.zarr --json");
        return json::parse(info.out).value("contentHash", info.out);
    }
};

TEST_F(Phases, AnyFormatGivesTheVolumeOfItsTime) {
    write("t.nii", niftiOf(3));
    write("apart.nrrd", nrrdOf(3, false));
    write("together.nrrd", nrrdOf(3, true));
    for (int time = 0; time < 3; ++time) {
        std::string one = niftiOf(1);
        one.replace(352, std::string::npos, voxelsOf(time));
        write("one.nii", one);
        const std::string phase = "--phase " + std::to_string(time + 1);
        const std::string expected = contentOf("one.nii", "");
        EXPECT_EQ(contentOf("t.nii", phase), expected) << time;
        EXPECT_EQ(contentOf("apart.nrrd", phase), contentOf("together.nrrd", phase)) << time;
    }
    expectRefused("import t.nii x.zarr", {"t.nii", "--phase N", "3 phases (1: 0 s, 2: 2.5 s, 3: 5 s)"});
    expectRefused("import t.nii x.zarr --phase 4", {"--phase between 1 and 3", "4 of 3 phases"});
    expectRefused("import apart.nrrd x.zarr", {"--phase N", "1: time 1"});
    write("one.nii", niftiOf(1));
    expectRefused("import one.nii x.zarr --phase 1", {"--phase", "one volume"});
    write("short.nii", niftiOf(3).substr(0, 20000));
    expectRefused("import short.nii x.zarr --phase 1", {"short.nii", "dim[4]"});
    EXPECT_THAT(run("info t.nii").out, HasSubstr("3 phases for --phase (1: 0 s, "));
}

TEST_F(Phases, AFilmHasAFrameForEachWithOneCameraAndFunction) {
    write("t.nii", niftiOf(3));
    const std::string film = "render t.nii --phase all -o frames --engine native --size 24x20 --fps 5";
    const Outcome first = run(film + " --json");
    ASSERT_EQ(first.exitCode, 0) << first.problems;
    EXPECT_EQ(json::parse(first.out)["drawn"], 3);
    EXPECT_EQ(json::parse(first.out)["phases"], 3);
    json camera, function;
    std::vector<std::string> hashes;
    for (int n = 0; n < 3; ++n) {
        const json manifest = manifestOf("frames/frame-00000" + std::to_string(n) + ".png");
        EXPECT_EQ(manifest["film"]["phase"], n + 1);
        EXPECT_EQ(manifest["film"]["phaseLabel"], n == 0 ? "0 s" : n == 1 ? "2.5 s" : "5 s");
        hashes.push_back(manifest["store"]["contentHash"]);
        const json& scene = manifest["scene"];
        if (n > 0) {
            EXPECT_EQ(scene["camera"], camera);
            EXPECT_EQ(scene["volumes"][0]["transferFunction"], function);
            EXPECT_NE(hashes[static_cast<std::size_t>(n) - 1], hashes.back());
        }
        camera = scene["camera"], function = scene["volumes"][0]["transferFunction"];
    }
    // It goes on: a frame that is gone is drawn again, the same.
    const std::string before = pixelsOf("frames/frame-000001.png");
    fs::remove(folder_ / "frames/frame-000001.png");
    const Outcome again = run(film + " --json");
    ASSERT_EQ(again.exitCode, 0) << again.problems;
    EXPECT_EQ(json::parse(again.out)["drawn"], 1);
    EXPECT_EQ(pixelsOf("frames/frame-000001.png"), before);
    // A frame is the still of its phase.
    json scene = manifestOf("frames/frame-000001.png")["scene"];
    scene["volumes"][0]["path"] = "t.nii";
    scene["volumes"][0]["phase"] = 2;
    write("still.json", scene.dump());
    const Outcome still = run("render still.json -o still.png --engine native --no-check");
    ASSERT_EQ(still.exitCode, 0) << still.problems;
    EXPECT_EQ(pixelsOf("still.png"), before);
    // So it is drawn again from the file that has all of them, too.
    ASSERT_EQ(run("cache clear").exitCode, 0);
    const Outcome redrawn = run("redraw frames/frame-000001.png --data t.nii -o redrawn.png");
    ASSERT_EQ(redrawn.exitCode, 0) << redrawn.problems << redrawn.out;
    EXPECT_EQ(pixelsOf("redrawn.png"), before);
    // While it turns, phases follow one another.
    const Outcome turn =
        run("render t.nii --phase all --turn 90 --frames 4 -o turn --engine native --size 12x10");
    ASSERT_EQ(turn.exitCode, 0) << turn.problems;
    EXPECT_EQ(manifestOf("turn/frame-000003.png")["film"]["phase"], 1);
}

// A slice per time is shown as with --slice, with its options, and is whole by itself.
TEST_F(Phases, OfOneSliceAreSlices) {
    write("t.nii", niftiOf(3, 1));
    const std::string render = "render t.nii --phase all --size 24x20 --no-check -o ";
    for (const char* options :
         {" --window -400,1200", " --window lung --value-colour inverse", " --slab 2:maximum"}) {
        const Outcome told = run(render + "a" + options);
        EXPECT_EQ(told.exitCode, 0) << told.problems;
        EXPECT_THAT(told.problems, Not(HasSubstr("name the folder")));
        EXPECT_THAT(told.problems, Not(HasSubstr("taken as")));
        EXPECT_EQ(run(render + "b --slice axial -q" + options).exitCode, 0) << options;
        for (const char* frame : {"frame-000000.png", "frame-000001.png", "frame-000002.png"}) {
            ASSERT_TRUE(exists(std::string("a/") + frame)) << frame;
            EXPECT_EQ(pixelsOf(std::string("a/") + frame), pixelsOf(std::string("b/") + frame)) << options;
        }
        fs::remove_all(folder_ / "a");
        fs::remove_all(folder_ / "b");
        fs::remove_all(folder_ / "cache");
    }
    const std::string notes = run(render + "c").problems;
    const std::size_t first = notes.find("one slice only, 2 mm thick\n");
    EXPECT_NE(first, std::string::npos) << notes;
    EXPECT_EQ(notes.find("one slice only", first + 1), std::string::npos) << "once for all phases";
    EXPECT_THAT(run("import t.nii --phase 2 one.zarr").problems, HasSubstr("one slice only, 2 mm thick\n"));
}

#if TESSERA_WITH_ANNOTATIONS
TEST_F(Phases, WordsOfFiguresNameThem) {
    write("t.nii", niftiOf(3));
    const auto wordsOf = [](const json& manifest, const char* key) {
        return manifest["scene"]["annotations"].value(key, "");
    };
    const std::string labels[] = {"0 s", "2.5 s", "5 s"};
    const std::string drawing = " --engine native --size 200x160 --no-check ";
    const Outcome film = run("render t.nii --phase all -o frames --engine native --size 200x160 "
                             "--title heart,{phase} --caption {phase}of{phase}");
    ASSERT_EQ(film.exitCode, 0) << film.problems;
    for (int n = 0; n < 3; ++n) {
        const std::string& label = labels[n];
        const std::string frame = "frames/frame-00000" + std::to_string(n) + ".png";
        EXPECT_EQ(wordsOf(manifestOf(frame), "title"), "heart," + label);
        EXPECT_EQ(wordsOf(manifestOf(frame), "caption"), label + "of" + label);
        // A frame is drawn again from its manifest, and is the still with these words.
        json scene = manifestOf(frame)["scene"];
        scene["volumes"][0].update({{"path", "t.nii"}, {"phase", n + 1}});
        write("still.json", scene.dump());
        ASSERT_EQ(run("render still.json -o still.png" + drawing).exitCode, 0);
        EXPECT_EQ(pixelsOf("still.png"), pixelsOf(frame));
        scene["annotations"]["title"] = "heart,{phase}";
        write("still.json", scene.dump());
        ASSERT_EQ(run("render still.json -o named.png" + drawing).exitCode, 0);
        EXPECT_EQ(pixelsOf("named.png"), pixelsOf(frame));
        EXPECT_EQ(run("redraw " + frame).exitCode, 0);
    }
    // Panels have their own; words that are the same in all stand once.
    const Outcome panels = run("render t.nii --panel volumes[0].phase=1 --panel volumes[0].phase=3 "
                               "--title {phase} --caption heart -o panels.png" +
                               drawing);
    ASSERT_EQ(panels.exitCode, 0) << panels.problems;
    EXPECT_EQ(manifestOf("panels.png")["figure"]["caption"], "heart");
    EXPECT_EQ(manifestOf("panels.png")["figure"]["title"], "");
    EXPECT_EQ(wordsOf(manifestOf("panels.png")["panels"][0], "title"), "0 s");
    EXPECT_EQ(wordsOf(manifestOf("panels.png")["panels"][1], "title"), "5 s");
    EXPECT_EQ(run("redraw panels.png").exitCode, 0);
    // Rows of a table likewise, beside its own columns.
    write("style.json", R"({"tesseraScene": 1, "volumes": [{"path": "t.nii"}], "image": {"size": [200, 160]},
                            "annotations": {"title": "{id}: {phase}"}})");
    write("t.csv", "id,--phase\na,2\nb,3\n");
    const Outcome batch = run("batch t.csv --scene style.json -o {id}.png --no-check");
    ASSERT_EQ(batch.exitCode, 0) << batch.problems;
    EXPECT_EQ(wordsOf(manifestOf("a.png"), "title"), "a: 2.5 s");
    EXPECT_EQ(wordsOf(manifestOf("b.png"), "title"), "b: 5 s");

    write("one.nii", niftiOf(1));
    makeSphere();
    const std::string named = " -o x.png --title {phase}";
    expectRefused("render s.zarr" + named, {"{phase}", "--phase N", "a store"});
    expectRefused("render one.nii" + named, {"{phase}", "files of one"});
    expectRefused("render t.nii" + named, {"{phase}", "--phase N"});
    const std::string longest(Annotations::kMostLetters - 16, 'x');
    const std::string grown = " --title {phase}{phase}" + longest;
    ASSERT_EQ(run("render t.nii --phase 1 -o x.png" + drawing + grown).exitCode, 0);
    write("ms.nii", niftiOf(3).replace(123, 1, std::string(1, 2 + 16))); // its times in ms
    ASSERT_EQ(run("render ms.nii --phase 2 -o x.png" + drawing + grown).exitCode, 0);
    EXPECT_THAT(wordsOf(manifestOf("x.png"), "title"), ::testing::StartsWith("0.0025 s0.0025 sxx"));
    std::string many;
    for (int n = 0; n < 140; ++n)
        many += "{phase}";
    expectRefused("render ms.nii -q --phase all -o f --title " + many, {"{phase}", "1000 letters"});
    EXPECT_FALSE(fs::exists(folder_ / "f"));
}
#endif

TEST_F(Phases, WhatHasNoneIsRefused) {
    write("one.nii", niftiOf(1));
    write("t.nii", niftiOf(2));
    makeSphere();
    expectRefused("render one.nii --phase all -o f", {"one.nii", "several phases"});
    expectRefused("render s.zarr --phase all -o f", {"s.zarr", "--phase", "a store"});
    expectRefused("render t.nii --phase all -o f.png", {"f.png"});
    expectRefused("render t.nii --phase some -o f", {"--phase", "all", "\"some\""});
    expectRefused("render t.nii --phase all --seconds 3 -o f", {"--seconds"});
    expectRefused("info t.nii --phase all", {"--phase"});
    expectRefused("render t.nii --phase all --add s.zarr -o f", {"--phase all", "one volume"});
}

constexpr const char* kLine = R"({"tesseraPath":1,
 "lines":[{"count":4,"spacing":10,"points":[[0,0,15],[0,0,5],[0,0,-5],[0,0,-15]],"radius":[9,9,9,9]}]})";

TEST_F(Phases, LinesAreReformed) {
    makeSphere();
    write("line.json", kLine);
    const std::string command =
        "render s.zarr --path line.json --mm-per-pixel 2 --across 20 -o p.png --json ";
    const Outcome three = run(command + "--straighten --angles 3 --slab 4:maximum");
    ASSERT_EQ(three.exitCode, 0) << three.problems;
    const json straight = manifestOf("p.png")["reformation"];
    EXPECT_EQ(straight["form"], "straightened");
    EXPECT_EQ(straight["anglesDegrees"], json({0.0, 60.0, 120.0}));
    EXPECT_EQ(straight["mmPerPixel"], 2.0);
    EXPECT_NEAR(straight["lineLengthMm"].get<double>(), 30, 0.1);
    EXPECT_EQ(straight["pictureSize"], json({10, 15}));
    EXPECT_EQ(straight["slab"], "maximum");
    EXPECT_EQ(straight["lineHash"].get<std::string>().size(), 16U);
    const Outcome curved = run(command + "--curved --direction 1,0,0");
    ASSERT_EQ(curved.exitCode, 0) << curved.problems;
    EXPECT_EQ(manifestOf("p.png")["reformation"]["form"], "stretched");
    EXPECT_EQ(manifestOf("p.png")["reformation"]["lineHash"], straight["lineHash"]);
    const Outcome across = run(command + "--straighten --sections 5 --angle 30");
    ASSERT_EQ(across.exitCode, 0) << across.problems;
    const json sections = manifestOf("p.png")["reformation"];
    ASSERT_EQ(sections["sectionsMm"].size(), 5U);
    EXPECT_NEAR(sections["sectionsMm"][1].get<double>(), 9, 0.1);
    EXPECT_EQ(manifestOf("p.png")["scene"]["image"]["size"][0], 10 + 5 * 18) << "one of 15 rows a column";
    ASSERT_EQ(run(command + "--sections 4 --slab 5").exitCode, 0);
    EXPECT_EQ(manifestOf("p.png")["reformation"]["form"], "sections");
    EXPECT_EQ(manifestOf("p.png")["scene"]["image"]["size"], json({4 * 10 + 3 * 8, 10}));
    expectRefused(command + "--straighten --directions cube", {"--straighten", "cube"});
    expectRefused(command + "--sections 4 --unfold", {"--unfold", "two"});
    expectRefused("render s.zarr --sections 4 -o p.png", {"--sections", "--path"});
    expectRefused(command + "--sections 201", {"--sections", "200"});
    expectRefused("render s.zarr --straighten -o p.png", {"--straighten", "--path"});
    expectRefused(command + "--straighten --curved", {"--straighten", "two"});
    expectRefused(command + "--curved --angle 3", {"--angle", "--straighten"});
    expectRefused(command + "--curved --direction 0,0,1", {"--direction", "at an angle to the line"});
    expectRefused(command + "--curved --direction 1,2", {"--direction", "X,Y,Z"});
    expectRefused(command + "--straighten --view left", {"--view"});
    expectRefused(command + "--straighten --size 20x20", {"--size", "--across"});
    expectRefused(command + "--straighten --engine native", {"--engine"});
    expectRefused(command + "--straighten --mode maximum", {"--mode", "slice"});
    expectRefused("render s.zarr -o p.png --across 3", {"--across", "--straighten"});
    expectRefused(command + "--straighten --add s.zarr", {"--straighten", "one volume"});
}

} // namespace
} // namespace tessera::test
