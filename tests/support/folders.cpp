#include "tests/support/folders.h"

#include <cstdlib>
#include <system_error>

namespace tessera::test {

std::filesystem::path sourceFolder() {
    return TESSERA_SOURCE_DIR;
}

std::filesystem::path testData() {
    const char* given = std::getenv("TESSERA_TEST_DATA");
    const std::filesystem::path folder = given ? given : sourceFolder() / "../shared/data";
    std::error_code error;
    return std::filesystem::is_directory(folder, error) ? folder : std::filesystem::path();
}

std::filesystem::path storePath(const std::string& name) {
    return std::filesystem::path(TESSERA_TEST_STORES) / (name + ".zarr");
}

} // namespace tessera::test
