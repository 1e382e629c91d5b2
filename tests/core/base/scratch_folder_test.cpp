// tests/core/base/scratch_folder_test.cpp: a scratch folder is private, and leaves nothing behind.
#include "core/base/program_folders.h"

#include "core/base/error.h"

#include <cstdlib>
#include <fstream>
#include <gtest/gtest.h>
#include <optional>
#include <string>

namespace tessera {
namespace {

namespace fs = std::filesystem;

TEST(ScratchFolder, IsItsOwnAndGoesWithAllItHolds) {
    std::optional<ScratchFolder> first(std::in_place);
    const ScratchFolder second;
    EXPECT_NE(first->path(), second.path());
    EXPECT_TRUE(fs::is_empty(first->path()));
    EXPECT_EQ(fs::status(first->path()).permissions(), fs::perms::owner_all)
        << "scans are nobody else's business";
    fs::create_directory(*first / "a");
    std::ofstream(*first / "a" / "b") << "text";
    const fs::path path = first->path();
    first.reset();
    EXPECT_FALSE(fs::exists(path));
    EXPECT_TRUE(fs::exists(second.path()));
}

TEST(ScratchFolder, SaysWhereNoneCanBeMade) {
    const char* const given = std::getenv("TMPDIR");
    const std::optional<std::string> before = given ? std::optional<std::string>(given) : std::nullopt;
    ::setenv("TMPDIR", "/no-such-folder", 1);
    EXPECT_THROW(ScratchFolder(), Error);
    before ? ::setenv("TMPDIR", before->c_str(), 1) : ::unsetenv("TMPDIR");
}

} // namespace
} // namespace tessera
