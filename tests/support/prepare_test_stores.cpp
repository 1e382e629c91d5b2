// Makes the stores that the image tests read, in the folder given: phantoms always, real scans where they are
// present. A fixture of ctest: runs once before them.
#include "bricking/import/importer.h"
#include "datasets/phantom.h"
#ifdef TESSERA_WITH_IMPORT
#include "bricking/import/open_source.h"
#include "tests/support/folders.h"
#endif

#include <cstdio>
#include <filesystem>

namespace {

void make(tessera::SlabSource& source, const std::filesystem::path& path) {
    tessera::MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20);
    tessera::ImportOptions options;
    options.force = true;
    const auto report = tessera::importToStore(source, path, ram, options);
    std::printf("%s: %llu voxels, %.2f s\n", path.filename().c_str(),
                static_cast<unsigned long long>(report.voxels), report.seconds);
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 2)
        return 2;
    const std::filesystem::path folder(argv[1]);
    std::filesystem::create_directories(folder);
    make(*tessera::makePhantom("marschner-lobb", {64, 64, 64}), folder / "marschner-lobb.zarr");
    make(*tessera::makePhantom("sphere", {70, 90, 50}), folder / "sphere.zarr");
    make(*tessera::makePhantom("checkerboard", {64, 40, 33}), folder / "checkerboard.zarr");
    make(*tessera::makePhantom("sphere", {33, 1, 70}), folder / "thin.zarr");
#ifdef TESSERA_WITH_IMPORT
    const std::filesystem::path data = tessera::test::testData();
    for (const auto& [name, source] :
         {std::pair("abdomen", "ct-abdomen-dicom"), std::pair("head", "ct-head-tilted-dicom")}) {
        if (!std::filesystem::exists(data / source)) {
            std::filesystem::remove_all(folder / (std::string(name) + ".zarr"));
            std::printf("%s: left out, %s is absent\n", name, (data / source).c_str());
            continue;
        }
        tessera::SourceOptions options;
        options.resampleZ = true;
        make(*tessera::openSource(data / source, options), folder / (std::string(name) + ".zarr"));
    }
#endif
    make(*tessera::makePhantom("torso", {150, 110, 173}), folder / "torso.zarr");
    return 0;
}
