// tests/support/program_fixture.h: runs the program inside a temporary folder and keeps what it said.
#pragma once

#include "core/base/program_folders.h"
#include "viewer/program.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <iostream>
#include <sstream>
#include <string>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

namespace tessera::test {

namespace fs = std::filesystem;

struct Outcome {
    int exitCode = -1;
    std::string out, problems;
};

inline std::string readAll(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
}

class Program : public ::testing::Test {
  protected:
    /// Runs `tessera arguments` inside the temporary folder, in a child process; words split at blanks, and
    /// '' is an empty one.
    Outcome run(const std::string& arguments) {
        int status = 0;
        ::waitpid(start(arguments), &status, 0);
        return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, readAll(folder_ / ".out"),
                readAll(folder_ / ".err")};
    }
    /// The same, without waiting for its end.
    pid_t start(const std::string& arguments) const {
        std::vector<std::string> words = {"tessera"};
        std::istringstream text(arguments);
        for (std::string word; text >> word;)
            words.push_back(word == "''" ? "" : word);
        const pid_t child = ::fork();
        if (child == 0)
            ::_exit(runInChild(words));
        return child;
    }
    int runInChild(std::vector<std::string>& words) const {
        fs::current_path(folder_.path());
        ::setenv("XDG_CACHE_HOME", (folder_ / "cache").c_str(), 1);
        ::setenv("XDG_CONFIG_HOME", (folder_ / "config").c_str(), 1);
        if (!std::freopen(".out", "w", stdout) || !std::freopen(".err", "w", stderr))
            return 100;
        std::vector<char*> argv;
        for (std::string& word : words)
            argv.push_back(word.data());
        argv.push_back(nullptr);
        const int code = tessera::runProgram(static_cast<int>(words.size()), argv.data());
        std::cout.flush(); // the parser prints its help there
        std::fflush(nullptr);
        return code;
    }
    /// Bad use: exit code 2, and one line that has all of the words.
    void expectRefused(const std::string& arguments, const std::vector<std::string>& words) {
        const Outcome outcome = run(arguments);
        EXPECT_EQ(outcome.exitCode, 2) << arguments << "\n" << outcome.problems;
        EXPECT_EQ(outcome.problems.rfind("tessera: ", 0), 0u) << outcome.problems;
        EXPECT_EQ(std::count(outcome.problems.begin(), outcome.problems.end(), '\n'), 1) << outcome.problems;
        EXPECT_EQ(outcome.problems.find('\033'), std::string::npos) << "colour, though no terminal";
        for (const std::string& word : words)
            EXPECT_THAT(outcome.problems, ::testing::HasSubstr(word)) << arguments;
    }
    /// Bad use where a choice is needed: the first line as expectRefused() has it, then the table of series.
    void expectRefusedWithTable(const std::string& arguments, const std::vector<std::string>& words) {
        const Outcome outcome = run(arguments);
        EXPECT_EQ(outcome.exitCode, 2) << arguments << "\n" << outcome.problems;
        EXPECT_EQ(outcome.problems.rfind("tessera: ", 0), 0u) << outcome.problems;
        const std::size_t line = outcome.problems.find('\n');
        EXPECT_EQ(outcome.problems.find("\n  series  "), line) << outcome.problems;
        EXPECT_THAT(outcome.problems.substr(0, line), ::testing::HasSubstr("expected")) << arguments;
        for (const std::string& word : words)
            EXPECT_THAT(outcome.problems, ::testing::HasSubstr(word)) << arguments;
    }
    void write(const std::string& name, const std::string& text) { std::ofstream(folder_ / name) << text; }
    void makeSphere() {
        const Outcome outcome = run("phantom sphere --size 40x33x24 -o s.zarr");
        ASSERT_EQ(outcome.exitCode, 0) << outcome.problems;
    }
    bool exists(const std::string& name) const { return fs::exists(folder_ / name); }

    const ScratchFolder folder_;
};

} // namespace tessera::test
