// tests/support/folders.h: paths of this checkout and its build, which no other object of the tests names.
#pragma once

#include <filesystem>
#include <string>

namespace tessera::test {

/// The repository.
std::filesystem::path sourceFolder();

/// Real files for tests ($TESSERA_TEST_DATA, else ../shared/data beside the repository), or an empty path.
std::filesystem::path testData();

/// A store that the fixture prepare_test_stores makes.
std::filesystem::path storePath(const std::string& name);

} // namespace tessera::test
