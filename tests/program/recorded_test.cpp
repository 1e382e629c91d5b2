// tests/program/recorded_test.cpp: the program does what it did: pictures, manifests, reports and messages
// are those that tests/program/recorded/ holds. A file there lists commands ("run") and what came of them.
// Where a change is meant, TESSERA_RECORD=1 writes the files anew, and their differences show what it
// changed.
#include "tests/support/folders.h"
#include "tests/support/program_fixture.h"
#include "tests/support/recorded.h"

namespace tessera::test {
namespace {

fs::path recordFolder() {
    return sourceFolder() / "tests/program/recorded";
}

std::vector<std::string> recordNames() {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(recordFolder()))
        if (entry.path().extension() == ".json")
            names.push_back(entry.path().stem().string());
    std::sort(names.begin(), names.end());
    return names;
}

class Recorded : public Program, public ::testing::WithParamInterface<std::string> {
  protected:
    /// What a command says and how it ends.
    nlohmann::json resultOf(const std::string& command) {
        const Outcome outcome = run(command);
        nlohmann::json result = {{"exit", outcome.exitCode}};
        if (!outcome.out.empty())
            result["out"] = contentOf(outcome.out, folder_.path());
        if (!outcome.problems.empty())
            result["problems"] = linesOf(outcome.problems, folder_.path());
        return result;
    }
    /// Files that the commands left, by their paths: pictures and JSON; of others only their names.
    nlohmann::json files() const {
        nlohmann::json found = nlohmann::json::object();
        for (const auto& entry : fs::recursive_directory_iterator(folder_.path())) {
            const std::string name = fs::relative(entry.path(), folder_.path()).string();
            const std::string ending = entry.path().extension().string();
            if (!entry.is_regular_file() || name.find(".zarr") != std::string::npos || name[0] == '.' ||
                name.rfind("cache/", 0) == 0 || name.rfind("in", 0) == 0)
                continue;
            if (ending == ".png" || ending == ".exr" || ending == ".tif") {
                found[name] = meansOf(entry.path());
                if (const std::string manifest = readManifest(entry.path()); !manifest.empty())
                    found[name]["manifest"] = contentOf(manifest, folder_.path());
            } else {
                found[name] = ending == ".json" ? contentOf(readAll(entry.path()), folder_.path()) : nullptr;
            }
        }
        return found;
    }
};

TEST_P(Recorded, Results) {
    const fs::path file = recordFolder() / (GetParam() + ".json");
    const auto record = nlohmann::json::parse(readAll(file));
    nlohmann::json found = {{"run", record.at("run")}, {"results", nlohmann::json::array()}};
    const auto inputs = record.value("inputs", nlohmann::json::object());
    for (const auto& [name, content] : inputs.items()) {
        found["inputs"][name] = content;
        write(name, content.is_string() ? content.get<std::string>() : content.dump());
    }
    for (const nlohmann::json& command : record.at("run"))
        found["results"].push_back(resultOf(command));
    found["files"] = files();
    if (std::getenv("TESSERA_RECORD")) {
        std::ofstream(file) << textOf(found);
        GTEST_SKIP() << "recorded " << file;
    }
    std::vector<std::string> differences;
    compare(record.at("results"), found["results"], "results", "", differences);
    compare(record.at("files"), found["files"], "files", "", differences);
    for (const std::string& difference : differences)
        ADD_FAILURE() << difference;
    if (!differences.empty())
        ADD_FAILURE() << "if that is meant: TESSERA_RECORD=1 writes " << file << " anew";
}

INSTANTIATE_TEST_SUITE_P(Program, Recorded, ::testing::ValuesIn(recordNames()),
                         [](const auto& info) { return info.param; });

} // namespace
} // namespace tessera::test
