// tests/program_accuracy_test.cpp: `tessera accuracy` from outside: its files, the columns of runs.csv,
// claimed bounds that hold, and errors that fall with the step. No time is tested.
#include "program_fixture.h"

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

TEST_F(Program, AccuracyRefusesWhatItCannotMeasure) {
    expectRefused("accuracy -o report", {"expected a scene", "--all"});
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
