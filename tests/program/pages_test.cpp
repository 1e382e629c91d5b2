// tests/program/pages_test.cpp: pages of the manual and completion in shells have every command, option and
// word that help has, and other programs understand them.
#include "tests/support/program_fixture.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <map>
#include <regex>
#include <set>

namespace tessera::test {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

/// First words of the lines of a part of help, "Subcommands:".
std::vector<std::string> listedIn(const std::string& help, const std::string& part) {
    std::vector<std::string> words;
    std::istringstream lines(
        help.substr(std::min(help.size(), help.find("\n" + part + "\n") + part.size() + 2)));
    std::string word;
    for (std::string line; std::getline(lines, line) && !line.empty();)
        if (line.starts_with("  ") && !line.starts_with("   ") && std::istringstream(line) >> word)
            words.push_back(word); // what is indented further goes on about the line before
    return words;
}

/// "-o,--output" of every option of help.
std::set<std::string> optionsListedIn(const std::string& help) {
    std::set<std::string> options;
    for (const std::string& names : listedIn(help, "Options:")) {
        std::istringstream parts(names);
        for (std::string name; std::getline(parts, name, ',');)
            options.insert(name);
    }
    return options;
}

class Pages : public Program {
  protected:
    /// Every command as it is called, "" for the program and "cache list" for a command of another, with its
    /// help.
    std::map<std::string, std::string> helpOfAll() {
        std::map<std::string, std::string> all;
        addHelp("", all);
        return all;
    }
    void addHelp(const std::string& command, std::map<std::string, std::string>& all) {
        const std::string help = run(command + " --help").out;
        all[command] = help;
        if (help.find("\nSubcommands:\n") == std::string::npos)
            return;
        for (const std::string& name : listedIn(help, "Subcommands:"))
            if (name != "accuracy" && name != "bench") // of tessera-bench
                addHelp(command.empty() ? name : command + " " + name, all);
    }
    void writePages() { ASSERT_EQ(run("--quiet man . --date 2026-11-29").exitCode, 0); }
    /// What a shell prints, as lines.
    static std::vector<std::string> linesOf(const std::string& command) {
        std::vector<std::string> lines;
        FILE* const pipe = ::popen(command.c_str(), "r");
        std::array<char, 4096> line{};
        while (pipe && std::fgets(line.data(), line.size(), pipe))
            lines.emplace_back(line.data(), std::string(line.data()).find_last_not_of("\n") + 1);
        if (pipe)
            ::pclose(pipe);
        return lines;
    }
    static bool has(const std::string& program) {
        return std::system(("command -v " + program + " >/dev/null 2>&1").c_str()) == 0;
    }
    /// What bash offers for the last of the words.
    std::vector<std::string> offered(const std::vector<std::string>& words) const {
        std::string command = "bash --norc -c 'source bash.txt; COMP_WORDS=(";
        for (const std::string& word : words)
            command += "\"" + word + "\" ";
        command += "); COMP_CWORD=" + std::to_string(words.size() - 1) +
                   "; _tessera; printf \"%s\\n\" \"${COMPREPLY[@]}\" | sed /^$/d'";
        return linesOf("cd " + folder_.path().string() + " && " + command);
    }
};

TEST_F(Pages, HaveEveryOptionOfHelp) {
    writePages();
    std::size_t options = 0;
    for (const auto& [command, help] : helpOfAll()) {
        const std::string first = command.substr(0, command.find(' '));
        const std::string page = readAll(folder_ / (first.empty() ? "tessera.1" : "tessera-" + first + ".1"));
        EXPECT_THAT(page, HasSubstr(".TH TESSERA")) << command;
        for (const std::string& option : optionsListedIn(help)) {
            EXPECT_THAT(page, HasSubstr("\\fB" + std::regex_replace(option, std::regex("-"), "\\-") + "\\fR"))
                << command;
            ++options;
        }
        for (const std::string& argument : listedIn(help, "Positionals:"))
            EXPECT_THAT(page, HasSubstr(".TP\n\\fI" + argument + "\\fR\n")) << command;
        // The first page leads to those of all commands, with a sentence about each, and they lead back.
        const std::string reference = ".BR tessera\\-" + first + " (1)";
        const std::string whole = readAll(folder_ / "tessera.1");
        if (first.empty())
            continue;
        EXPECT_THAT(whole, HasSubstr(".TP\n" + reference + "\n")) << command;
        EXPECT_THAT(whole.substr(whole.find(".SH SEE ALSO")), HasSubstr(reference)) << command;
        EXPECT_THAT(page.substr(page.find(".SH SEE ALSO")), HasSubstr(".BR tessera (1)")) << command;
        const std::size_t about = whole.find(".TP\n" + reference + "\n") + reference.size() + 5;
        EXPECT_GT(whole.find(".TP", about) - about, 10U) << command;
    }
    EXPECT_GT(options, 150u);
}

TEST_F(Pages, AreUnderstoodByMan) {
    writePages();
    int read = 0;
    for (const auto& entry : fs::directory_iterator(folder_.path())) {
        if (entry.path().extension() != ".1")
            continue;
        const std::string page = entry.path().string();
        if (has("groff")) {
            EXPECT_THAT(linesOf("groff -man -Tutf8 -ww -z " + page + " 2>&1"), IsEmpty());
        }
        if (has("mandoc")) {
            EXPECT_THAT(linesOf("mandoc -T lint -W warning " + page + " 2>&1"), IsEmpty());
        }
        ++read;
    }
    EXPECT_GT(read, 10);
    if (!has("groff") && !has("mandoc"))
        GTEST_SKIP() << "neither groff nor mandoc";
}

TEST_F(Pages, BashCompletesWhatHelpHas) {
    const Outcome script = run("completion bash");
    ASSERT_EQ(script.exitCode, 0) << script.problems;
    write("bash.txt", script.out);
    std::set<std::string> common = {"-q", "-v", "--quiet", "--verbose"};
    for (const auto& [command, help] : helpOfAll()) {
        std::vector<std::string> words = {"tessera"};
        std::istringstream parts(command);
        for (std::string part; parts >> part;)
            words.push_back(part);
        words.emplace_back("-");
        std::set<std::string> expected = optionsListedIn(help);
        expected.insert(common.begin(), common.end());
        const std::vector<std::string> found = offered(words);
        EXPECT_EQ(std::set<std::string>(found.begin(), found.end()), expected) << command;
    }
}

TEST_F(Pages, BashCompletesCommandsWordsAndFiles) {
    write("bash.txt", run("completion bash").out);
    EXPECT_THAT(offered({"tessera", "re"}), UnorderedElementsAre("render", "redraw"));
    EXPECT_THAT(offered({"tessera", "-q", "cache", ""}), ElementsAre("list", "clear", "path"));
    EXPECT_THAT(offered({"tessera", "render", "x.zarr", "--mode", "max"}), ElementsAre("maximum"));
    EXPECT_THAT(offered({"tessera", "render", "--preset", "bo"}), ElementsAre("bone", "bone-1"));
    EXPECT_THAT(offered({"tessera", "completion", ""}), ElementsAre("bash", "zsh"));
    // Values and arguments are names of files, which readline itself completes.
    EXPECT_THAT(offered({"tessera", "render", "--output", "-"}), IsEmpty());
    EXPECT_THAT(offered({"tessera", "render", "x"}), IsEmpty());
    EXPECT_THAT(offered({"tessera", "render", "render", "--fi"}), Contains("--fit")); // a file of that name
}

TEST_F(Pages, ZshUnderstandsItsScript) {
    const Outcome script = run("completion zsh");
    write("zsh.txt", script.out);
    EXPECT_THAT(script.out, HasSubstr("#compdef tessera\n"));
    for (const auto& [command, help] : helpOfAll())
        for (const std::string& option : optionsListedIn(help))
            EXPECT_THAT(script.out, HasSubstr(option + "[")) << command;
    for (const auto& [command, help] : helpOfAll()) { // each has a function, which is called
        const std::string function =
            std::regex_replace("_tessera" + (command.empty() ? "" : "_" + command), std::regex(" "), "_");
        EXPECT_THAT(script.out, HasSubstr(function + "() {\n"));
        EXPECT_THAT(script.out, HasSubstr(command.empty() ? "compdef _tessera tessera\n" : function + " ;;"));
    }
    if (!has("zsh"))
        GTEST_SKIP() << "no zsh";
    EXPECT_THAT(linesOf("zsh -n " + (folder_ / "zsh.txt").string() + " 2>&1"), IsEmpty());
}

TEST_F(Pages, RefuseWhatMeansNothing) {
    expectRefused("completion fish", {"SHELL", "bash, zsh", "fish"});
    expectRefused("man none", {"none"});
    expectRefused("man . --date today", {"--date", "YYYY-MM-DD", "today"});
}

} // namespace
} // namespace tessera::test
