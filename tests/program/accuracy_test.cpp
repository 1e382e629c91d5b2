// tests/program/accuracy_test.cpp: `tessera accuracy` from outside: its files, the columns of runs.csv,
// claimed bounds that hold, and errors that fall with the step. No time is tested.
#include "tests/support/program_fixture.h"

#include <map>

namespace tessera::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// Lines of a CSV file as fields by column; quoted fields keep their commas.
std::vector<std::map<std::string, std::string>> readCsv(const fs::path& path) {
    std::ifstream file(path);
    const auto fields = [](const std::string& line) {
        std::vector<std::string> out(1);
        bool quoted = false;
        for (const char c : line)
            if (c == '"')
                quoted = !quoted;
            else if (c == ',' && !quoted)
                out.emplace_back();
            else
                out.back() += c;
        return out;
    };
    std::string line;
    std::getline(file, line);
    const std::vector<std::string> names = fields(line);
    std::vector<std::map<std::string, std::string>> rows;
    while (std::getline(file, line)) {
        const std::vector<std::string> values = fields(line);
        EXPECT_EQ(values.size(), names.size()) << line;
        rows.emplace_back();
        for (std::size_t i = 0; i < std::min(names.size(), values.size()); ++i)
            rows.back()[names[i]] = values[i];
    }
    return rows;
}

TEST_F(Program, AccuracyMeasuresAScene) {
    makeSphere();
    write("peers.csv", "renderer,time_min_ms,rmse\nanother one,5,0.01\n");
    const Outcome outcome = run("accuracy s.zarr -o report --quick --size 24x24 --integrators midpoint "
                                "--peers peers.csv --ram 400MiB --no-shading --gl-device software");
    ASSERT_EQ(outcome.exitCode, 0) << outcome.problems;
    const std::string page = readAll(folder_ / "report" / "accuracy.md");
    for (const char* word : {"## Machine and reference", "| T11 |", "## Scene: s", "## Stiff extinction",
                             "## Defaults", "## Runs, failures and omissions", "FLIP"})
        EXPECT_THAT(page, HasSubstr(word));
    EXPECT_THAT(page, Not(HasSubstr(folder_.path().string()))) << "a path of this machine";
    EXPECT_THAT(page,
                HasSubstr("Made by `tessera accuracy SCENE -o FOLDER --quick --integrators midpoint "
                          "--peers FILE --size 24x24 --no-shading --ram 400MiB --gl-device software`, "));
    EXPECT_THAT(page, Not(HasSubstr("peers.csv"))) << "a file of this machine";
    EXPECT_THAT(page, HasSubstr("| another one |"));
    EXPECT_THAT(page, Not(HasSubstr("| NO |"))) << "the proof of the reference fails";

    const auto rows = readCsv(folder_ / "report" / "accuracy" / "runs.csv");
    ASSERT_GT(rows.size(), 10u);
    std::map<double, double, std::greater<>> errors; // by step, coarse first
    for (const auto& row : rows) {
        EXPECT_EQ(row.at("bound_ok"), "1");
        EXPECT_EQ(row.at("nan_count"), "0");
        EXPECT_EQ(row.at("scene"), "s");
        EXPECT_LE(std::stod(row.at("p99_9")), std::stod(row.at("max_abs")));
        EXPECT_LT(std::stod(row.at("ref_err")), 1e-7);
        if (row.at("fetch") == "exact")
            errors[std::stod(row.at("step_vox"))] = std::stod(row.at("rmse"));
    }
    ASSERT_EQ(errors.size(), 4u);
    for (auto next = std::next(errors.begin()); next != errors.end(); ++next)
        EXPECT_LT(next->second, std::prev(next)->second) << "step " << next->first;
    EXPECT_THAT(readAll(folder_ / "report" / "accuracy" / "fail.csv"), HasSubstr("scene,setting,what"));
}

// The way other renderers get onto the page: scenes are kept, measured by another program, and all is drawn.
TEST_F(Program, AccuracyKeepsItsScenesAndShowsOtherRenderersOnThem) {
    const Outcome kept = run("accuracy --all --only sphere boundary-layer --quick --keep-scenes kept");
    ASSERT_EQ(kept.exitCode, 0) << kept.problems;
    for (const char* file :
         {"kept/sphere.json", "kept/boundary-layer.json", "kept/sphere.zarr", "kept/ramp.zarr"})
        EXPECT_TRUE(exists(file)) << file;
    ASSERT_EQ(
        run("render kept/sphere.json -o sphere.png --size 16x16 --gl-device software --no-check").exitCode,
        0);

    const std::string names = "scene,renderer,time_min_ms,rmse\n";
    write("a.csv", names + "sphere,\"vtk gpu, whole volume (216 KiB)\",5,0.01\nnose,vtk gpu,5,0.01\n");
    write("b.csv", names + "boundary-layer,another,6,0.02\n");
    const Outcome outcome =
        run("accuracy --all --only sphere boundary-layer --quick --seconds 1 --integrators "
            "midpoint --peers a.csv b.csv -o report --gl-device software");
    ASSERT_EQ(outcome.exitCode, 0) << outcome.problems;
    const std::string page = readAll(folder_ / "report" / "accuracy.md");
    EXPECT_THAT(
        page, HasSubstr("`tessera accuracy --all -o FOLDER --only sphere boundary-layer --quick --seconds 1 "
                        "--integrators midpoint --peers FILE FILE --gl-device software`, "));
    const std::size_t layer = page.find("## Scene: boundary-layer"), stiff = page.find("## Stiff");
    ASSERT_LT(layer, stiff);
    const std::string first = page.substr(0, layer), second = page.substr(layer, stiff - layer);
    EXPECT_THAT(first, HasSubstr("| vtk gpu, whole volume (216 KiB) |"));
    EXPECT_THAT(first, Not(HasSubstr("| another |")));
    EXPECT_THAT(second, HasSubstr("| another |"));
    EXPECT_THAT(second, Not(HasSubstr("| vtk gpu")));
    EXPECT_THAT(page, HasSubstr("Other renderers of `nose`: measured, but of no scene of this page."));
}

TEST_F(Program, AccuracyRefusesWhatItCannotMeasure) {
    expectRefused("accuracy -o report", {"expected a scene", "--all"});
    expectRefused("accuracy --all", {"-o FOLDER"});
    expectRefused("accuracy x.zarr --keep-scenes here", {"--keep-scenes", "--all"});
    expectRefused("accuracy none.zarr -o report", {"none.zarr"});
    expectRefused("accuracy x.zarr --all -o report", {"found both"});
    expectRefused("accuracy --all --only sphare -o report", {"--only", "nearest: \"sphere\""});
    expectRefused("accuracy x.zarr -o report --integrators midpiont", {"--integrators", "nearest"});
    makeSphere();
    write("peers.csv", "renderer,rmse\n");
    expectRefused("accuracy s.zarr -o report --peers peers.csv", {"peers.csv", "time_min_ms"});
}

} // namespace
} // namespace tessera::test
