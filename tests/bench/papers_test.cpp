// tests/bench/papers_test.cpp: the table of the papers' systems names what is there.
#include "tests/bench/papers/papers.h"
#include "tests/support/folders.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <set>
#include <sstream>
#include <string>

namespace tessera::bench {
namespace {

std::string pageText(const std::filesystem::path& file) {
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
}

/// The headings of a page as links name them.
std::set<std::string> sectionsOf(const std::filesystem::path& page) {
    std::set<std::string> sections;
    std::istringstream lines(pageText(page));
    for (std::string line; std::getline(lines, line);) {
        if (!line.starts_with('#'))
            continue;
        std::string name;
        for (const char c : line.substr(std::min(line.find(' '), line.size() - 1) + 1))
            if (std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_')
                name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
            else if (c == ' ')
                name += '-';
        sections.insert(name);
    }
    return sections;
}

TEST(PaperSystems, AreAllThereAndWhereTheTableSays) {
    std::set<std::string> ids;
    for (const PaperSystem& system : paperSystems()) {
        EXPECT_TRUE(ids.insert(system.id).second) << system.id << " stands twice";
        EXPECT_TRUE(std::filesystem::exists(test::sourceFolder() / system.where))
            << system.id << ": " << system.where;
        EXPECT_FALSE(std::string(system.status).empty()) << system.id;
        EXPECT_EQ(std::string(system.status).find("not yet"), std::string::npos) << system.id;
        const std::string at = system.measured, page = at.substr(0, at.find('#'));
        EXPECT_EQ(page == at, at.starts_with("tests/")) << system.id << ": a section, or tests";
        const std::filesystem::path file =
            test::sourceFolder() / (page == at ? "" : "docs/measurements") / page;
        EXPECT_TRUE(std::filesystem::exists(file)) << system.id << ": " << at;
        if (page != at) {
            EXPECT_TRUE(sectionsOf(file).contains(at.substr(page.size() + 1))) << system.id << ": " << at;
        }
    }
    const auto expect = [&](const char* paper, int count) {
        for (int n = 1; n <= count; ++n)
            EXPECT_TRUE(ids.contains(paper + std::to_string(n))) << paper << n << " is missing";
    };
    expect("C", 63), expect("H", 8), expect("W", 8), expect("V", 11);
    EXPECT_EQ(ids.size(), 90u);
}

/// The page has the row of every system, and readers get there.
TEST(PaperSystems, StandOnAPageThatIsLinked) {
    const std::string page = pageText(test::sourceFolder() / "docs/measurements/papers.md");
    for (const PaperSystem& system : paperSystems()) {
        const std::string row = std::string("| ") + system.id + " | " + system.what + " | `" + system.where +
                                "` | " + system.status + " | ";
        const std::size_t at = page.find(row);
        ASSERT_NE(at, std::string::npos) << row;
        const std::string measured = system.measured, section = measured.substr(measured.find('#') + 1);
        EXPECT_NE(page.substr(at, page.find('\n', at) - at).find(section), std::string::npos) << row;
    }
    for (const char* from : {"README.md", "docs/guide/errors.md"})
        EXPECT_NE(pageText(test::sourceFolder() / from).find("measurements/papers.md"), std::string::npos)
            << from;
}

} // namespace
} // namespace tessera::bench
