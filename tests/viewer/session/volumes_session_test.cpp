// tests/viewer/session/volumes_session_test.cpp: scenes of several volumes that a window opens: all of its
// pictures show all of them, or the state says why not.
#include "bricking/import/importer.h"
#include "core/base/program_folders.h"
#include "tests/support/looker.h"

#include <fstream>
#include <gtest/gtest.h>

namespace tessera::test {
namespace {

/// A file of a scene of two even media in the same voxels, red and blue.
class TwoMedia {
  public:
    /// @param more  keys of the scene
    explicit TwoMedia(const std::string& more = "") {
        VolumeInfo info;
        info.extentVoxels = {40, 36, 38};
        info.type = ValueType::i16;
        FormulaSource source(info, [](const glm::dvec3&) { return 100.0; });
        MemoryBudget ram("RAM", "--ram", kRamBytes);
        importToStore(source, folder_ / "even.zarr", ram, {});
        const auto medium = [](const char* rgb) {
            return std::string(
                       R"({"path":"even.zarr","transferFunction":{"scalarOpacity":[[0,0.02],[200,0.02]],)") +
                   R"("scalarOpacityUnitDistance":1,"rgbTransferFunction":[[0,)" + rgb + "]]}}";
        };
        std::ofstream(file) << R"({"tesseraScene":1,"volumes":[)" << medium("1,0,0") << "," << medium("0,0,1")
                            << R"(],"camera":{"view":"anterior","parallelProjection":true,"fit":"volume"},)"
                            << more << R"("shading":{"shade":false}})";
    }

  private:
    ScratchFolder folder_;

  public:
    const std::filesystem::path file = folder_ / "two.json";
};

/// Of a ray through both media, 36 mm long, in red and blue alike.
void expectBoth(const glm::vec4& pixel) {
    EXPECT_NEAR(pixel.r, pixel.b, 1e-4);
    EXPECT_NEAR(pixel.a, -std::expm1(72 * std::log1p(-0.02)), 5e-3) << "both extinctions along 36 mm";
}
glm::vec4 middleOf(const ShownPicture& picture) {
    const Image& image = picture.image;
    return image.at(image.size.x / 2, image.size.y / 2);
}

TEST(VolumesSession, AllPicturesShowAllAndKeepWhatTheSceneSays) {
    const TwoMedia media;
    Looker looker(true);
    const Scene scene = looker.opened(media.file);
    ASSERT_EQ(scene.volumes.size(), 2u);
    EXPECT_TRUE(scene.volumes[1].path.is_absolute());
    EXPECT_EQ(scene.volumes[1].path.filename(), "even.zarr");
    expectBoth(middleOf(*looker.stillOf(looker.viewing->show(scene, false))));

    Looker moving(false);
    Scene same = moving.opened(media.file);
    expectBoth(middleOf(*moving.wholeOf(moving.viewing->show(same, false))));
    EXPECT_EQ(moving.viewing->state().firstAlone, "");
    const std::uint64_t turning = moving.viewing->show(same, true);
    EXPECT_TRUE(moving.comesTo([&] {
        const auto picture = moving.viewing->picture();
        return picture && picture->asked >= turning && picture->stage == Stage::moving;
    }));
    expectBoth(middleOf(*moving.viewing->picture()));

    same.volumes[1].opacity = 0;
    const glm::vec4 red = middleOf(*moving.wholeOf(moving.viewing->show(same, false)));
    EXPECT_EQ(red.b, 0);
    EXPECT_NEAR(red.a, -std::expm1(36 * std::log1p(-0.02)), 5e-3);
    same.volumes[1] = same.volumes[0];
    const glm::vec4 redder = middleOf(*moving.wholeOf(moving.viewing->show(same, false)));
    EXPECT_EQ(redder.b, 0);
    EXPECT_NEAR(redder.a, -std::expm1(72 * std::log1p(-0.02)), 5e-3);
}

TEST(VolumesSession, WhatNoPictureOfSeveralHasIsDrawnOfTheFirstAlone) {
    const TwoMedia media(R"("isosurfaces":[{"value":5000}],)");
    Looker moving(false);
    const Scene scene = moving.opened(media.file);
    const glm::vec4 pixel = middleOf(*moving.wholeOf(moving.viewing->show(scene, false)));
    EXPECT_EQ(pixel.b, 0);
    EXPECT_NEAR(pixel.a, -std::expm1(36 * std::log1p(-0.02)), 5e-3);
    EXPECT_NE(moving.viewing->state().firstAlone.find("isosurfaces"), std::string::npos);
}

// Stills of several volumes have no paths of light, and say so; interactive pictures show all of the volumes.
TEST(VolumesSession, PathsOfLightLeaveNoVolumeOut) {
    const TwoMedia media(R"("lighting":{"transport":{}},)");
    Looker looker;
    const Scene scene = looker.opened(media.file);
    looker.viewing->show(scene, false);
    ASSERT_TRUE(looker.comesTo([&] { return !looker.viewing->state().problem.empty(); }));
    EXPECT_NE(looker.viewing->state().problem.find("lighting.transport: expected none"), std::string::npos)
        << looker.viewing->state().problem;
    EXPECT_EQ(looker.viewing->state().firstAlone, "");
    ASSERT_TRUE(looker.viewing->picture());
    expectBoth(middleOf(*looker.viewing->picture()));
}

} // namespace
} // namespace tessera::test
