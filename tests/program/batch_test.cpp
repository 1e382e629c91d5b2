// tests/program/batch_test.cpp: a table becomes pictures, a row each; what fails does not stop the rest, and
// what is done is not done twice.
#include "tests/support/program_fixture.h"

#include "core/image/image_file.h"

#include <csignal>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sys/resource.h>

namespace tessera::test {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr char kScene[] = R"({"tesseraScene":1,"volumes":[{"path":"s.zarr","transferFunction":"auto"}],
    "image":{"size":[24,16]},"camera":{"view":"anterior"},"quality":{"samples":1}})";

class Batch : public Program {
  protected:
    void SetUp() override {
        makeSphere();
        write("scene.json", kScene);
    }
    /// Of `tessera batch t.csv` into out/, with further options.
    Outcome batch(const std::string& options = "") {
        return run("batch t.csv --scene scene.json -o out/{id}.png --no-check " + options);
    }
    std::map<std::string, std::string> pictures(const std::string& folder = "out") const {
        std::map<std::string, std::string> found;
        if (exists(folder))
            for (const auto& entry : fs::recursive_directory_iterator(folder_ / folder))
                if (entry.is_regular_file())
                    found[entry.path().filename().string()] = readAll(entry.path());
        return found;
    }
    void expectTableRefused(const std::string& table, const std::vector<std::string>& words) {
        write("t.csv", table);
        expectRefused("batch t.csv --scene scene.json -o out/{id}.png", words);
        EXPECT_FALSE(exists("out")) << "something was drawn of\n" << table;
    }
    /// Lines of a record, by their ids.
    std::map<std::string, json> record(const std::string& name) const {
        std::map<std::string, json> rows;
        std::istringstream text(readAll(folder_ / name));
        for (std::string line; std::getline(text, line);)
            rows[json::parse(line)["id"]] = json::parse(line);
        return rows;
    }
    Image picture(const std::string& name) const { return readImage(folder_ / name); }
    static bool same(const Image& a, const Image& b) { return a.size == b.size && a.pixels == b.pixels; }
};

TEST_F(Batch, GoesOnAfterFailuresAndDrawsNothingTwice) {
    std::string table = "id,camera.view,shading.ambient,volumes[0].path\r\n";
    const char* const views[] = {"left", "right", "anterior"};
    for (int n = 1; n <= 40; ++n)
        table += "p" + std::to_string(n) + "," + (n == 11 ? "sideways" : views[n % 3]) + "," +
                 (n == 22 ? "7" : "0." + std::to_string(10 + n)) + "," + (n == 33 ? "missing.zarr" : "") +
                 "\r\n";
    write("t.csv", table);
    const Outcome first = batch("--report r.json --jobs 3");
    EXPECT_EQ(first.exitCode, 1);
    EXPECT_THAT(first.out, HasSubstr("40 rows: 37 drawn, 3 failed\n"));
    EXPECT_THAT(first.out, HasSubstr("  row 11, p11: t.csv:12 (camera.view): expected "));
    EXPECT_THAT(first.out, HasSubstr("  row 22, p22: t.csv:23 (shading.ambient): expected "));
    EXPECT_THAT(first.out, HasSubstr("  row 33, p33: "));
    EXPECT_THAT(first.out, HasSubstr("missing.zarr: expected "));
    EXPECT_THAT(first.problems, HasSubstr("p1: wrote out/p1.png"));
    EXPECT_THAT(first.problems, HasSubstr("tessera: p33: "));
    EXPECT_THAT(first.problems, HasSubstr("tessera: t.csv: 3 of 40 rows failed\n"));
    const auto drawn = pictures();
    EXPECT_EQ(drawn.size(), 37u);
    const auto rows = record("r.json");
    ASSERT_EQ(rows.size(), 40u);
    for (const auto& [id, row] : rows) {
        const bool isThere = drawn.count(id + ".png") > 0;
        EXPECT_EQ(row["state"], isThere ? "drawn" : "failed") << id;
        EXPECT_EQ(row.contains("message"), !isThere) << id;
        EXPECT_EQ("p" + std::to_string(row["row"].get<int>()), id);
    }
    const Outcome second = batch("--report r.csv -q");
    EXPECT_EQ(second.exitCode, 1);
    EXPECT_THAT(second.out, HasSubstr("40 rows: 0 drawn, 37 unchanged and left as they are, 3 failed\n"));
    EXPECT_EQ(pictures(), drawn);
    EXPECT_THAT(readAll(folder_ / "r.csv"), HasSubstr("row,id,output,state,seconds,message\n"));
    EXPECT_THAT(readAll(folder_ / "r.csv"), HasSubstr(",p5,out/p5.png,unchanged,"));
    EXPECT_THAT(batch("--again --json -q").out, HasSubstr("\"drawn\": 37"));
}

// A row is what `tessera render` draws of the same scene.
TEST_F(Batch, ARowIsAPictureOfRender) {
    write("t.csv", "id,camera.view,window,mode,isosurfaces[0].value\n"
                   "a,left,,,\nb,\"[30,15]\",,,300\nc,,\"100,400\",maximum,\nd,superior,,,\n");
    ASSERT_EQ(batch("--jobs 2").exitCode, 0);
    const std::string render = "render scene.json --no-check -q -o ";
    for (const char* one : {"a.png --view left", "b.png --view 30,15 --isosurface 300",
                            "c.png --mode maximum --window 100,400", "d.png --view superior"})
        ASSERT_EQ(run(render + one).exitCode, 0) << one;
    for (const char* name : {"a.png", "b.png", "c.png", "d.png"})
        EXPECT_TRUE(same(picture(name), picture(std::string("out/") + name))) << name;
    EXPECT_EQ(run("redraw out/b.png --data s.zarr").exitCode, 0) << "from the manifest";
}

// Columns of words, and those that are left out.
TEST_F(Batch, AColumnMayBeAPresetOrASlice) {
    write("t.csv", "id,#comment,preset,slice\na,\"old, of 2019\",skin-1,\nb,,,coronal:3\n");
    ASSERT_EQ(batch().exitCode, 0);
    const std::string render = "render scene.json --no-check -q -o ";
    ASSERT_EQ(run(render + "a.png --preset skin-1").exitCode, 0);
    ASSERT_EQ(run(render + "b.png --slice coronal:3").exitCode, 0);
    for (const char* name : {"a.png", "b.png"})
        EXPECT_TRUE(same(picture(name), picture(std::string("out/") + name))) << name;
    write("t.csv", "id,volumes[0].transferFunction\na,bonee\n");
    EXPECT_THAT(batch("--dry-run").problems, HasSubstr("bonee"));
    EXPECT_EQ(batch("--dry-run").exitCode, 1);
}

// An option's name means what the option does.
TEST_F(Batch, AColumnMayBeAnOption) {
    write("t.csv", "id,view,--projection,fit,mm-per-pixel,slice,slab\na,left,,,,,\nb,,parallel,volume,,,\n"
                   "c,\"30,10\",,,2 mm,,\nd,,,,,coronal,4:maximum\n");
    ASSERT_EQ(batch().exitCode, 0);
    const std::string render = "render scene.json --no-check -q -o ";
    for (const char* one : {"a.png --view left", "b.png --projection parallel --fit volume",
                            "c.png --view 30,10 --mm-per-pixel 2", "d.png --slice coronal --slab 4:maximum"})
        ASSERT_EQ(run(render + one).exitCode, 0) << one;
    for (const char* name : {"a.png", "b.png", "c.png", "d.png"})
        EXPECT_TRUE(same(picture(name), picture(std::string("out/") + name))) << name;
    fs::remove_all(folder_ / "out");
    for (const auto& [column, key] : {std::pair{"isosurface", "isosurfaces[0].value"},
                                      {"--crop", "cuts.boxes"},
                                      {"mesh", "meshes[0].path"},
                                      {"--cut-plane", "cuts.planes"}})
        expectTableRefused("id," + std::string(column) + "\na,1\n",
                           {column, "nearest: \"" + std::string(key) + "\""});
    expectTableRefused("id,--view,camera.view\na,left,\n", {"--view", "camera.view", "both"});
    expectTableRefused("id,slice,--slice\na,axial,\n", {"both"});
    write("t.csv", "id,comment\na,b\n");
    EXPECT_THAT(batch().problems, Not(HasSubstr("nearest")));
}

// A style for many volumes need not name one.
TEST_F(Batch, ASceneWithoutVolumesTakesThoseOfTheRows) {
    json style = json::parse(kScene);
    style.erase("volumes");
    write("scene.json", style.dump());
    ASSERT_EQ(run("phantom marschner-lobb --size 20x20x20 -o m.zarr -q").exitCode, 0);
    write("t.csv", "id,volumes[0].path,volumes[0].opacity\na,s.zarr,\nb,m.zarr,0.5\nc,,\n");
    const Outcome outcome = batch("-q");
    EXPECT_THAT(outcome.out, HasSubstr("3 rows: 2 drawn, 1 failed\n"));
    EXPECT_THAT(outcome.out, HasSubstr("row 3, c: t.csv:4: expected a volume"));
    const std::string look = " --view anterior --size 24x16 --samples 1 --no-check -q ";
    ASSERT_EQ(run("render s.zarr -o a.png" + look).exitCode, 0);
    ASSERT_EQ(run("render m.zarr -o b.png --set volumes[0].opacity=0.5" + look).exitCode, 0);
    for (const char* name : {"a.png", "b.png"})
        EXPECT_TRUE(same(picture(name), picture(std::string("out/") + name))) << name;
    fs::remove_all(folder_ / "out");
    for (const char* columns : {"id,volumes[0].opacity\na,1\n", "id,volumes[1].path\na,s.zarr\n"})
        expectTableRefused(columns, {"t.csv", "a volume (--scene, or a column \"volumes[0].path\")", "none"});
    style["shading"] = {{"ambiet", 1}};
    write("scene.json", style.dump());
    expectTableRefused("id,volumes[0].path\na,s.zarr\n", {"scene.json", "ambiet"});
}

// A mode that shows no transfer function takes volumes of any values, though the scene names none.
TEST_F(Batch, AModeWithoutAFunctionTakesAnyValues) {
    ASSERT_EQ(run("phantom marschner-lobb --size 20x20x20 -o m.zarr -q").exitCode, 0);
    write(
        "scene.json",
        R"({"tesseraScene":1,"volumes":[{"path":"s.zarr"}],"image":{"size":[24,16]},"quality":{"samples":1}})");
    write("t.csv",
          "id,volumes[0].path,mode,valueColour\na,m.zarr,slice,\nb,s.zarr,slice,\nc,m.zarr,maximum,inverse\n"
          "d,m.zarr,average,\ne,m.zarr,slice,transferFunction\nf,m.zarr,,\n");
    const Outcome outcome = batch("-q");
    EXPECT_THAT(outcome.out, HasSubstr("6 rows: 4 drawn, 2 failed\n"));
    for (const char* row : {"  row 5, e: ", "  row 6, f: "})
        EXPECT_THAT(outcome.out, HasSubstr(std::string(row) + "preset bone-1: expected values in HU"));
    const std::string look = " --size 24x16 --samples 1 --no-check -q ";
    ASSERT_EQ(run("render m.zarr --slice axial -o a.png" + look).exitCode, 0);
    ASSERT_EQ(run("render s.zarr --slice axial -o b.png" + look).exitCode, 0);
    ASSERT_EQ(run("render m.zarr --mode maximum --value-colour inverse -o c.png" + look).exitCode, 0);
    ASSERT_EQ(run("render m.zarr --mode average -o d.png" + look).exitCode, 0);
    for (const char* name : {"a.png", "b.png", "c.png", "d.png"})
        EXPECT_TRUE(same(picture(name), picture(std::string("out/") + name))) << name;
}

// What spreadsheets leave: rows of separators, TRUE and FALSE.
TEST_F(Batch, TakesWhatSpreadsheetsWrite) {
    write("t.csv", "shading.shade,shading.ambient\r\nFALSE,0.5\r\nTrue,0.5\r\n,\r\n,\r\n");
    const Outcome outcome = run("batch t.csv --scene scene.json -o out/{row}.png --no-check");
    EXPECT_EQ(outcome.exitCode, 0) << outcome.problems;
    EXPECT_THAT(outcome.out, HasSubstr("2 rows: 2 drawn\n"));
    EXPECT_THAT(outcome.problems, HasSubstr("t.csv: 2 rows of empty cells count for nothing\n"));
    EXPECT_FALSE(same(picture("out/1.png"), picture("out/2.png")));
    write("t.csv", "id;shading.ambient\na;0,5\nb;0x1\nc;0.5\n");
    const Outcome commas = batch("--dry-run");
    EXPECT_THAT(commas.out,
                HasSubstr("row 1, a: t.csv:2 (shading.ambient): expected a number with a decimal point"));
    EXPECT_THAT(commas.out, HasSubstr("row 2, b: t.csv:3 (shading.ambient): expected "));
    EXPECT_THAT(commas.out, HasSubstr("1 would be drawn, 2 failed\n"));
}

// Only what changed is drawn again: the scene, the data, or the picture itself.
TEST_F(Batch, DrawsAgainWhatChanged) {
    ASSERT_EQ(run("phantom sphere --size 24x24x24 -o t.zarr -q").exitCode, 0);
    write("t.csv", "id,volumes[0].path,shading.ambient\na,s.zarr,0.1\nb,t.zarr,0.1\nc,s.zarr,0.2\nd,,\n");
    ASSERT_EQ(batch().exitCode, 0);
    const auto before = pictures();
    const auto expectDrawn = [&](const std::set<std::string>& ids, const char* why) {
        ASSERT_EQ(batch("-q --report r.json").exitCode, 0) << why;
        for (const auto& [id, row] : record("r.json"))
            EXPECT_EQ(row["state"], ids.count(id) ? "drawn" : "unchanged") << why << ": " << id;
    };
    expectDrawn({}, "nothing changed");
    write("t.csv", "id,volumes[0].path,shading.ambient\na,s.zarr,0.1\nb,t.zarr,0.1\nc,s.zarr,0.3\nd,,\n");
    expectDrawn({"c"}, "a cell");
    ASSERT_EQ(run("phantom sphere --size 24x24x25 -o t.zarr -q --force").exitCode, 0);
    expectDrawn({"b"}, "the data");
    std::string scene = kScene;
    write("scene.json", scene.replace(scene.find("anterior"), 8, "superior"));
    expectDrawn({"a", "b", "c", "d"}, "the scene");
    write("out/a.png", "no picture");
    fs::remove(folder_ / "out" / "b.png");
    expectDrawn({"a", "b"}, "the files");
    json manifest = json::parse(readManifest(folder_ / "out" / "d.png"));
    manifest["commit"] = "another";
    writeImage(folder_ / "out" / "d.png", picture("out/d.png"), manifest.dump());
    expectDrawn({"d"}, "the program");
    ASSERT_EQ(
        run("batch t.csv --scene scene.json -o out/{id}.png --verify quick -q --report r.json").exitCode, 0);
    EXPECT_EQ(record("r.json")["a"]["state"], "drawn") << "the options";
}

TEST_F(Batch, CellsStandInNamesAndTexts) {
    std::string scene = kScene;
    scene.insert(scene.size() - 1, R"(,"annotations":{"title":"{id} of {{{who}}}","caption":"row {row}"})");
    write("scene.json", scene);
    write("t.csv", "who;id\nJane;7\nDoe;8\n");
    const Outcome outcome = run("batch t.csv --scene scene.json -o out/{who}/{id}-{row}.png --no-check");
    if (outcome.problems.find("annotations") == std::string::npos) { // of a program that draws them
        EXPECT_EQ(outcome.exitCode, 0) << outcome.problems;
        const json manifest = json::parse(readManifest(folder_ / "out/Doe/8-2.png"));
        EXPECT_EQ(manifest["scene"]["annotations"]["title"], "8 of {Doe}");
        EXPECT_EQ(manifest["scene"]["annotations"]["caption"], "row 2");
        EXPECT_TRUE(exists("out/Jane/7-1.png"));
    }
    expectRefused("batch t.csv --scene scene.json -o out/{whom}.png", {"-o", "{whom}", "{who}"});
    expectRefused("batch t.csv --scene scene.json -o out/{who.png", {"-o", "\"{\" alone"});
    scene.replace(scene.find("{id}"), 4, "{ld}");
    write("scene.json", scene);
    expectRefused("batch t.csv --scene scene.json -o out/{id}.png", {"annotations.title", "{ld}", "{id}"});
}

TEST_F(Batch, RefusesBeforeAnythingIsDrawn) {
    expectTableRefused("id\na\nb\na\n", {"t.csv:4", "out/a.png", "t.csv:2"});
    expectTableRefused("id,shading.ambiet\na,0.1\n", {"t.csv", "shading.ambiet", "shading.ambient"});
    expectTableRefused("id,views\na,left\n", {"\"views\"", "view"});
    expectTableRefused("id,notes\na,x\n", {"\"notes\""});
    expectTableRefused("id,window,--window\na,\"1,2\",\n", {"window", "both"});
    for (const char* bad : {"../b", "/tmp/b", "", "..", ".", "x/y", "\"a\nb\"", "\x7f"})
        expectTableRefused("id,shading.ambient\na,0.1\n" + std::string(bad) + ",0.1\n", {"t.csv:3"});
    expectTableRefused("id\na\n" + std::string(300, 'x') + "\n", {"t.csv:3", "200 bytes"});
    write("t.csv", "id\na\n");
    expectRefused("batch t.csv --scene scene.json -o out/{id}/../../x.png", {"-o", "stays in its folder"});
    expectRefused("batch t.csv --scene scene.json -o out/{id}.jpg", {"a.jpg"});
    expectRefused("batch t.csv --scene scene.json -o out/{id}.png --report r.txt", {"--report", "r.txt"});
    expectRefused("batch missing.csv --scene scene.json -o out/{id}.png", {"missing.csv"});
    expectRefused("batch t.csv --scene scene.json -o out/{id}.png --ram 8MiB --jobs 4",
                  {"--ram", "4 rows at once", "24 x 16", "--jobs"});
    write("t.csv", "id,image.size\na,24x16\nb,2000x1500\nc,\n"); // the largest of all rows counts
    expectRefused("batch t.csv --scene scene.json -o out/{id}.png --ram 90MiB --jobs 2",
                  {"--ram", "2 rows at once", "2000 x 1500", "--jobs"});
    expectRefused("batch t.csv --scene scene.json -o out/{id}.png --claim --again", {"--again"});
}

// Tables of other programs are read; those that are no tables are refused, with their line.
TEST_F(Batch, ReadsTablesStrictly) {
    const auto drawn = [&](const std::string& table) {
        write("t.csv", table);
        fs::remove_all(folder_ / "out");
        const Outcome outcome = batch("-q");
        EXPECT_EQ(outcome.exitCode, 0) << table << outcome.problems;
        std::set<std::string> names;
        for (const auto& [name, bytes] : pictures())
            names.insert(name);
        return names;
    };
    using Names = std::set<std::string>;
    EXPECT_EQ(drawn("\xef\xbb\xbfid,window\r\na,\r\n\r\nb,\r\n"), (Names{"a.png", "b.png"}));
    EXPECT_EQ(drawn("id\tmode\na\tmaximum"), (Names{"a.png"}));
    EXPECT_EQ(drawn("id;mode\na;maximum\r"), (Names{"a.png"}));
    EXPECT_EQ(drawn("id,mode\n\"a, \"\"b\"\"\",maximum\n"), (Names{"a, \"b\".png"}));
    EXPECT_EQ(drawn("id\n\xc3\xa4\n"), (Names{"\xc3\xa4.png"}));
    EXPECT_EQ(drawn("id\n"), Names{});
    fs::remove_all(folder_ / "out");
    expectTableRefused("", {"t.csv", "names of columns"});
    expectTableRefused("\n\n", {"t.csv", "names of columns"});
    expectTableRefused("id,mode\na\n", {"t.csv:2", "2 cells", "found 1"});
    expectTableRefused("id,mode\na,maximum\nb,maximum,7\n", {"t.csv:3", "2 cells", "found 3"});
    expectTableRefused("id,mode\na,maximum\nb,\"maxi", {"t.csv:3", "quote"});
    expectTableRefused("id,mode\na,maxi\"mum\n", {"t.csv:2", "quote"});
    expectTableRefused("id,mode\na,\"maxi\"mum\n", {"t.csv:2", "quote"});
    expectTableRefused(std::string("id\na\nb\0c\n", 9), {"t.csv:3", "byte of 0"});
    expectTableRefused("id\na\n\xff\xfe\n", {"t.csv:3", "UTF-8"});
    expectTableRefused("id\n\xed\xa0\x80\n", {"t.csv:2", "UTF-8"});
    expectTableRefused("id,id\na,b\n", {"\"id\" twice"});
    expectTableRefused("id,\na,b\n", {"column 2"});
    expectTableRefused("id,mode\na," + std::string(100000, 'x') + "\n", {"t.csv:2", "64 KiB"});
    write("t.csv", "id\na\n");
    expectRefused("batch t.csv --scene scene.json -o out/{id}.png --ram 4B", {"--ram"});
}

TEST_F(Batch, ADryRunChecksAllAndDrawsNothing) {
    write("t.csv", "id,shading.ambient,volumes[0].path\na,0.1,\nb,7,\nc,0.1,missing.nii\n");
    const Outcome outcome = batch("--dry-run");
    EXPECT_EQ(outcome.exitCode, 1);
    EXPECT_THAT(outcome.out, HasSubstr("row 1, a: out/a.png would be drawn\n"));
    EXPECT_THAT(outcome.out, HasSubstr("3 rows: 1 would be drawn, 2 failed\n"));
    EXPECT_THAT(outcome.out, HasSubstr("missing.nii"));
    EXPECT_FALSE(exists("out"));
    write("t.csv", "id,shading.ambient\na,0.1\nb,0.2\n");
    ASSERT_EQ(batch().exitCode, 0);
    EXPECT_THAT(batch("--dry-run").out, HasSubstr("2 rows: 0 would be drawn, 2 unchanged\n"));
    EXPECT_THAT(batch("--dry-run --again").out, HasSubstr("2 rows: 2 would be drawn\n"));
}

TEST_F(Batch, ARowThatNeedsMoreThanItsShareIsDrawnAlone) {
    ASSERT_EQ(run("phantom sphere --size 96x96x96 -o s.zarr -q --force").exitCode, 0);
    const std::string render = "render scene.json --light studio --no-check --json -q -o x.png --ram ";
    const Outcome lit = run(render + "90MiB");
    ASSERT_EQ(lit.exitCode, 0) << lit.problems;
    ASSERT_THAT(run(render + "30MiB").problems, HasSubstr("raise --ram"));
    json scene = json::parse(lit.out)["scene"];
    scene["volumes"][0]["path"] = "s.zarr";
    write("scene.json", scene.dump());
    write("t.csv", "id,lighting\na,\nb,{}\nc,\n");
    const Outcome outcome = batch("--ram 90MiB --jobs 3 -q --report r.json");
    EXPECT_EQ(outcome.exitCode, 0) << outcome.out << outcome.problems;
    EXPECT_THAT(outcome.out, HasSubstr("3 rows: 3 drawn\n"));
    EXPECT_THAT(batch("--ram 30MiB --jobs 1 -q --again").out, HasSubstr("1 drawn, 2 failed"));
}

// Every row is drawn by one of them, and all end with every picture there.
TEST_F(Batch, ProcessesShareRowsByClaims) {
    std::string table = "id,shading.ambient\n";
    for (int n = 10; n < 34; ++n)
        table += "p" + std::to_string(n) + ",0." + std::to_string(n) + "\n";
    write("t.csv", table);
    const std::string command = "batch t.csv --scene scene.json -o out/{id}.png --no-check -q --claim ";
    std::vector<pid_t> processes;
    for (const char* name : {"a", "b", "c"})
        processes.push_back(start(command + "--jobs 1 --report " + name + ".json"));
    for (const pid_t process : processes) {
        int status = 0;
        ::waitpid(process, &status, 0);
        EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << readAll(folder_ / ".err");
    }
    std::map<std::string, int> times;
    for (const char* name : {"a.json", "b.json", "c.json"}) {
        const auto rows = record(name);
        EXPECT_EQ(rows.size(), 24u) << name;
        for (const auto& [id, row] : rows)
            times[id] += row["state"] == "drawn" ? 1 : 0;
    }
    for (const auto& [id, count] : times)
        EXPECT_EQ(count, 1) << id;
    EXPECT_EQ(pictures().size(), 24u) << "and no lock files";
}

// Ctrl-C leaves whole pictures, and says what was reached; the next run goes on.
TEST_F(Batch, EndsCleanlyWhenInterrupted) {
    std::string table = "id,shading.ambient,image.size\n";
    for (int n = 100; n < 400; ++n)
        table += "p" + std::to_string(n) + ",0." + std::to_string(n) + ",200x150\n";
    write("t.csv", table);
    const pid_t process =
        start("batch t.csv --scene scene.json -o out/{id}.png --no-check -q --report r.json --jobs 2");
    const auto whole = [&] {
        const auto all = pictures();
        return std::ranges::count_if(all, [](const auto& one) { return one.first[0] != '.'; });
    };
    for (int n = 0; n < 1000 && whole() < 4; ++n)
        ::usleep(10000);
    ::kill(process, SIGINT);
    int status = 0;
    ::waitpid(process, &status, 0);
    ASSERT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 130);
    EXPECT_THAT(readAll(folder_ / ".out"), HasSubstr("not reached"));
    const auto left = pictures();
    EXPECT_GE(left.size(), 4u);
    EXPECT_LT(left.size(), 300u);
    for (const auto& [name, bytes] : left) {
        EXPECT_EQ(name[0], 'p') << "an unfinished file";
        EXPECT_EQ(picture("out/" + name).size, glm::ivec2(200, 150));
        EXPECT_EQ(record("r.json").count(name.substr(0, name.find('.'))), 1u) << name;
    }
    write("t.csv", table.substr(0, table.find("p110")));
    EXPECT_THAT(batch("-q --json").out, HasSubstr("\"failed\": 0"));
}

// Memory does not grow with the rows.
TEST_F(Batch, MemoryIsThatOfTheRowsAtOnce) {
    const auto peakKiB = [&](int rows) {
        std::string table = "id,shading.ambient\n";
        for (int n = 0; n < rows; ++n)
            table += "p" + std::to_string(n) + ",0." + std::to_string(100 + n) + "\n";
        write("t.csv", table);
        fs::remove_all(folder_ / "out");
        const Outcome outcome = batch("--jobs 2 -q --json");
        EXPECT_EQ(outcome.exitCode, 0) << outcome.problems;
        rusage use{};
        ::getrusage(RUSAGE_CHILDREN, &use); // the largest so far
        return use.ru_maxrss;
    };
    const long few = peakKiB(20), many = peakKiB(200);
    EXPECT_LT(many, few + 4096) << "KiB";
}

// A lock file that cannot be made is no other process's.
TEST_F(Batch, ClaimsInAFolderThatCannotBeWrittenFail) {
    write("t.csv", "id\na\n");
    for (const char* claim : {"", " --claim"}) {
        const Outcome outcome =
            run("batch t.csv --scene scene.json -o /proc/{id}.png --no-check" + std::string(claim));
        EXPECT_EQ(outcome.exitCode, 1) << outcome.problems;
        EXPECT_THAT(outcome.out, HasSubstr("1 rows: 0 drawn, 1 failed\n  row 1, a: /proc/"));
    }
}

// It never takes the place of what it is about.
TEST_F(Batch, TheRecordIsAFileOfItsOwn) {
    write("t.csv", "id\na\nb\n");
    const std::string command = "batch t.csv --scene scene.json -o out/{id}.png --no-check -q --report ";
    expectRefused(command + "t.csv", {"--report", "t.csv", "the table"});
    expectRefused(command + "scene.json", {"--report", "scene.json", "--scene"});
    fs::create_symlink("t.csv", folder_ / "link.csv");
    expectRefused(command + "link.csv", {"--report", "link.csv", "the table"});
    fs::create_symlink("out/a.png", folder_ / "picture.csv");
    expectRefused(command + "picture.csv", {"--report", "out/a.png"});
    EXPECT_THAT(readAll(folder_ / "t.csv"), HasSubstr("id\na\nb\n"));
    EXPECT_EQ(readAll(folder_ / "scene.json"), kScene);
    EXPECT_FALSE(exists("out"));
    fs::create_directory(folder_ / "out");
    fs::create_symlink("../r.csv", folder_ / "out" / "b.png");
    expectRefused(command + "r.csv", {"t.csv:3", "--report"});
    fs::remove(folder_ / "out" / "b.png");
    ASSERT_EQ(run(command + "new/folder/r.csv").exitCode, 0) << "its folder is made";
    const std::string record = readAll(folder_ / "new/folder/r.csv");
    EXPECT_THAT(record, HasSubstr("b,out/b.png,drawn,"));
    ASSERT_EQ(run(command + "new/folder/r.csv --dry-run").exitCode, 0);
    EXPECT_EQ(readAll(folder_ / "new/folder/r.csv"), record) << "a dry run erases nothing";
    ASSERT_EQ(run(command + "other/r.csv --dry-run").exitCode, 0);
    EXPECT_FALSE(exists("other"));
    expectRefused(command + "t.csv --dry-run", {"--report", "the table"});
}

TEST_F(Batch, ThePathOfTheSceneIsOfTheWorkingFolder) {
    fs::create_directory(folder_ / "tables");
    write("tables/t.csv", "id,shading.ambient\na,0.2\n");
    const Outcome outcome =
        run("batch tables/t.csv --scene s.zarr -o out/{id}.png --no-check --set image.size=24x16");
    const Outcome plain = run("batch tables/t.csv --scene s.zarr -o out/{id}.png --no-check");
    EXPECT_EQ(plain.exitCode, 0) << outcome.problems << plain.problems;
    EXPECT_TRUE(exists("out/a.png"));
    write("tables/t.csv", "id,volumes[0].path\nb,t.zarr\n");
    ASSERT_EQ(run("phantom sphere --size 24x24x24 -o tables/t.zarr -q").exitCode, 0);
    EXPECT_EQ(run("batch tables/t.csv --scene s.zarr -o out/{id}.png --no-check").exitCode, 0);
    EXPECT_TRUE(exists("out/b.png"));
}

// Whatever lies where a picture goes, it is drawn, and once.
TEST_F(Batch, PicturesThatAreOddOrCutOffAreDrawnAgain) {
    write("t.csv", "id\na\n");
    for (const char* ending : {".png", ".tif", ".exr"}) {
        const std::string name = std::string("out/a") + ending;
        const auto draws = [&](const char* why) {
            const Outcome outcome =
                run(std::string("batch t.csv --scene scene.json -o out/{id}") + ending + " --no-check -q");
            EXPECT_EQ(outcome.exitCode, 0) << why << outcome.problems;
            EXPECT_THAT(outcome.out, HasSubstr("1 rows: 1 drawn\n")) << why << ending;
            EXPECT_THAT(
                run(std::string("batch t.csv --scene scene.json -o out/{id}") + ending + " --no-check -q")
                    .out,
                HasSubstr("0 drawn, 1 unchanged"))
                << why << ending;
        };
        draws("nothing there");
        for (const char* key : {"program", "commit", "options", "data"})
            for (const char* value : {"5", "null", "[]", "{\"a\":[]}"}) {
                json manifest = json::parse(readManifest(folder_ / name));
                manifest[key] = json::parse(value);
                writeImage(folder_ / name, picture(name), manifest.dump());
                draws(key);
                if (ending != std::string(".png"))
                    break; // as of PNG
            }
        const std::string whole = readAll(folder_ / name);
        for (const std::size_t bytes : {std::size_t{1}, std::size_t{8}, std::size_t{40}, whole.size() / 2}) {
            write(name, whole.substr(0, whole.size() - bytes));
            draws("cut off");
        }
    }
}

TEST_F(Batch, MoreRowsAtOnceThanTheSystemLetsRunAreRefused) {
    std::string table = "id\n";
    for (int n = 0; n < 1500; ++n)
        table += "p" + std::to_string(n) + "\n";
    write("t.csv", table);
    const std::string command = "batch t.csv --scene scene.json -o out/{id}.png --no-check -q --again ";
    expectRefused(command + "--jobs 4097", {"--jobs", "from 1 to 4096"});
    expectRefused(command + "--jobs 0", {"--jobs"});
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    rlimit before{};
    ::getrlimit(RLIMIT_AS, &before);
    rlimit few = before;
    few.rlim_cur = rlim_t{4} << 30; // less than the stacks of 1500 threads
    ::setrlimit(RLIMIT_AS, &few);
    const Outcome outcome = run(command + "--jobs 1500 --ram 100GiB");
    ::setrlimit(RLIMIT_AS, &before);
    EXPECT_EQ(outcome.exitCode, 2) << outcome.problems;
    EXPECT_THAT(outcome.problems, HasSubstr("--jobs: expected as many rows at once as the system has"));
#endif
}

TEST_F(Batch, RowsMayBePages) {
    if (run("render scene.json --no-check -q -o x.pdf").exitCode != 0)
        GTEST_SKIP() << "a program without pages";
    write("t.csv", "id\na\n");
    for (const char* ending : {".pdf", ".svg"}) {
        const std::string command =
            std::string("batch t.csv --scene scene.json -o out/{id}") + ending + " --no-check -q";
        const Outcome outcome = run(command);
        EXPECT_EQ(outcome.exitCode, 0) << outcome.problems;
        EXPECT_THAT(run(command).out, HasSubstr("0 drawn, 1 unchanged"));
        const std::string name = std::string("out/a") + ending;
        const std::string whole = readAll(folder_ / name);
        write(name, whole.substr(0, whole.size() - 20));
        EXPECT_THAT(run(command).out, HasSubstr("1 rows: 1 drawn"));
        EXPECT_EQ(readAll(folder_ / name).size(), whole.size());
    }
}

} // namespace
} // namespace tessera::test
