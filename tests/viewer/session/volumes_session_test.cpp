// tests/viewer/session/volumes_session_test.cpp: scenes of several volumes that a window opens: stills show
// all of them, interactive pictures the first.
#include "bricking/import/importer.h"
#include "core/base/program_folders.h"
#include "tests/support/looker.h"

#include <fstream>
#include <gtest/gtest.h>

namespace tessera::test {
namespace {

TEST(VolumesSession, StillsShowAllAndKeepWhatTheSceneSays) {
    const ScratchFolder folder;
    VolumeInfo info;
    info.extentVoxels = {40, 36, 38};
    info.type = ValueType::i16;
    FormulaSource source(info, [](const glm::dvec3&) { return 100.0; });
    MemoryBudget ram("RAM", "--ram", kRamBytes);
    importToStore(source, folder / "even.zarr", ram, {});
    const auto medium = [](const char* rgb) {
        return std::string(
                   R"({"path":"even.zarr","transferFunction":{"scalarOpacity":[[0,0.02],[200,0.02]],)") +
               R"("scalarOpacityUnitDistance":1,"rgbTransferFunction":[[0,)" + rgb + "]]}}";
    };
    const auto file = folder / "two.json";
    std::ofstream(file) << R"({"tesseraScene":1,"volumes":[)" << medium("1,0,0") << "," << medium("0,0,1")
                        << R"(],"camera":{"view":"anterior","parallelProjection":true,"fit":"volume"},)"
                        << R"("shading":{"shade":false}})";
    Looker looker(true);
    const Scene scene = looker.opened(file);
    ASSERT_EQ(scene.volumes.size(), 2u);
    EXPECT_TRUE(scene.volumes[1].path.is_absolute());
    EXPECT_EQ(scene.volumes[1].path.filename(), "even.zarr");
    const auto middleOf = [](const ShownPicture& picture) {
        const Image& image = picture.image;
        return image.at(image.size.x / 2, image.size.y / 2);
    };
    const glm::vec4 still = middleOf(*looker.stillOf(looker.viewing->show(scene, false)));
    EXPECT_NEAR(still.r, still.b, 1e-4);
    EXPECT_NEAR(still.a, -std::expm1(72 * std::log1p(-0.02)), 5e-3) << "both extinctions along 36 mm";

    Looker moving(false);
    const Scene same = moving.opened(file);
    const glm::vec4 first = middleOf(*moving.wholeOf(moving.viewing->show(same, false)));
    EXPECT_EQ(first.b, 0);
    EXPECT_NEAR(first.a, -std::expm1(36 * std::log1p(-0.02)), 5e-3);
}

} // namespace
} // namespace tessera::test
