// tests/program/recorded_test.cpp: the program does what it did: pictures, manifests, reports and messages
// are those that tests/program/recorded/ holds. A file there lists commands ("run") and what came of them.
// Where a change is meant, TESSERA_RECORD=1 writes the files anew, and their differences show what it
// changed.
#include "tests/support/exr_layers.h"
#include "tests/support/folders.h"
#include "tests/support/program_fixture.h"
#include "tests/support/recorded.h"

#include <map>

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
    /// What a command says and how it ends. `flip FILE PLACE` is no command: it changes all bits of a byte,
    /// of a place below 0 counted from the file's end.
    nlohmann::json resultOf(const std::string& command) {
        std::istringstream words(command);
        std::string word, file;
        long place = 0;
        if (words >> word >> file >> place && word == "flip") {
            std::string bytes = readAll(folder_ / file);
            bytes.at(place < 0 ? bytes.size() - static_cast<std::size_t>(-place)
                               : static_cast<std::size_t>(place)) ^= '\xff';
            write(file, bytes);
            return nullptr;
        }
        const Outcome outcome = run(command);
        nlohmann::json result = {{"exit", outcome.exitCode}};
        if (!outcome.out.empty())
            result["out"] = contentOf(outcome.out, folder_.path());
        if (!outcome.problems.empty())
            result["problems"] = linesOf(outcome.problems, folder_.path());
        return result;
    }
    /// Files that the commands left, by their paths: pictures and JSON; of others length and digest of their
    /// bytes, of stores a digest a part.
    nlohmann::json files() const {
        nlohmann::json found = nlohmann::json::object();
        std::map<std::string, fs::path> paths;
        for (const auto& entry : fs::recursive_directory_iterator(folder_.path()))
            if (entry.is_regular_file())
                paths[fs::relative(entry.path(), folder_.path()).string()] = entry.path();
        std::map<std::string, std::map<std::string, std::string>> stores; // bytes, by store and part
        for (const auto& [name, path] : paths) {
            if (name[0] == '.' || name.rfind("cache/", 0) == 0 || name.rfind("in", 0) == 0)
                continue;
            const std::string ending = path.extension().string();
            if (const std::size_t at = name.find(".zarr/"); at != std::string::npos) {
                const std::string inside = name.substr(at + 6);
                stores[name.substr(0, at + 5)][inside.substr(0, inside.find('/'))] +=
                    inside + '\n' + readAll(path);
            } else if (ending == ".png" || ending == ".exr" || ending == ".tif") {
                found[name] = meansOf(path);
                if (const std::string manifest = readManifest(path); !manifest.empty())
                    found[name]["manifest"] = contentOf(manifest, folder_.path());
                if (ending == ".exr")
                    if (const nlohmann::json layers = layersOf(path); !layers.empty())
                        found[name]["layers"] = layers;
            } else if (ending == ".json") {
                found[name] = contentOf(readAll(path), folder_.path());
            } else {
                const std::string bytes = readAll(path);
                found[name] = {{"bytes", bytes.size()}};
                if (ending != ".vdb") // has a number that is another every time
                    found[name]["digest"] = digestOf(bytes);
            }
        }
        for (const auto& [store, parts] : stores)
            for (const auto& [part, bytes] : parts)
                found[store][part] = digestOf(bytes);
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
        fs::create_directories((folder_ / name).parent_path());
        write(name, content.is_string()         ? content.get<std::string>()
                    : content.contains("bytes") ? bytesOf(content["bytes"].get<std::string>())
                                                : content.dump());
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
