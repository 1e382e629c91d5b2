// tests/bench/papers_test.cpp: the table of the papers' systems names what is there.
#include "tests/bench/papers/papers.h"
#include "tests/support/folders.h"

#include <filesystem>
#include <gtest/gtest.h>
#include <set>

namespace tessera::bench {
namespace {

TEST(PaperSystems, AreAllThereAndWhereTheTableSays) {
    std::set<std::string> ids;
    for (const PaperSystem& system : paperSystems()) {
        EXPECT_TRUE(ids.insert(system.id).second) << system.id << " stands twice";
        EXPECT_TRUE(std::filesystem::exists(test::sourceFolder() / system.where))
            << system.id << ": " << system.where;
        EXPECT_FALSE(std::string(system.status).empty()) << system.id;
        EXPECT_EQ(std::string(system.status).find("not yet"), std::string::npos) << system.id;
        const std::string page = system.measured;
        EXPECT_TRUE(page.empty() ||
                    std::filesystem::exists(test::sourceFolder() / "docs/measurements" / page))
            << system.id << ": " << page;
    }
    const auto expect = [&](const char* paper, int count) {
        for (int n = 1; n <= count; ++n)
            EXPECT_TRUE(ids.contains(paper + std::to_string(n))) << paper << n << " is missing";
    };
    expect("C", 63), expect("H", 8), expect("W", 8), expect("V", 11);
    EXPECT_EQ(ids.size(), 90u);
}

} // namespace
} // namespace tessera::bench
