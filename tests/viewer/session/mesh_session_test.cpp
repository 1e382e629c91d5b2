// tests/viewer/session/mesh_session_test.cpp: meshes of a scene that a window opens: drawn at rest as
// `render` draws them, picked where they contribute most, kept as long as their scene.
#include "bricking/import/importer.h"
#include "render/geometry/shape.h"
#include "tests/support/looker.h"

#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <unistd.h>

namespace tessera::test {
namespace {

namespace fs = std::filesystem;

/// A volume of one value, which a function shows as thin fog or not at all.
class MeshSession : public testing::Test {
  protected:
    void SetUp() override {
        folder_ = fs::temp_directory_path() / ("tessera-mesh-session-" + std::to_string(::getpid()));
        fs::create_directories(folder_);
        VolumeInfo info;
        info.extentVoxels = {40, 48, 36};
        info.type = ValueType::i16;
        info.patientFromVoxel = glm::dmat4(1);
        FormulaSource source(info, [](const glm::dvec3& p) { return p.y < 24 ? 100.0 : 101.0; });
        MemoryBudget ram("RAM", "--ram", kRamBytes);
        importToStore(source, folder_ / "even.zarr", ram, {});
        info_ = info;
    }
    void TearDown() override { fs::remove_all(folder_); }
    /// @param perMm  opacity of the volume
    fs::path scene(double perMm, const std::string& meshes) const {
        const fs::path file = folder_ / ("scene-" + std::to_string(perMm) + ".json");
        std::ofstream(file)
            << R"({"tesseraScene":1,"volumes":[{"path":"even.zarr","transferFunction":{)"
            << R"("scalarOpacity":[[0,)" << perMm << R"(],[200,)" << perMm
            << R"(]],"scalarOpacityUnitDistance":1}}],"camera":{"view":"anterior","parallelProjection":true,"fit":"volume"},)"
            << R"("meshes":)" << meshes << "}";
        return file;
    }
    static PickedPlace picked(Looker& looker, const glm::dvec2& place) {
        const std::uint64_t question = looker.viewing->pick(place);
        EXPECT_TRUE(looker.comesTo(
            [&] { return looker.viewing->picked() && looker.viewing->picked()->number >= question; }));
        return *looker.viewing->picked();
    }
    fs::path folder_;
    VolumeInfo info_;
};

TEST_F(MeshSession, PicksWhatContributesMost) {
    const std::string balls =
        R"([{"tube":{"points":[[20,24,18]],"radius":6},"opacity":0.5},{"tube":{"points":[[20,-30,18]],"radius":3},"opacity":0.2}])";
    Looker looker(false);
    Scene thin = looker.opened(scene(0.0001, balls));
    looker.wholeOf(looker.viewing->show(thin, false));
    const PickedPlace middle = picked(looker, glm::dvec2(kPicture) / 2.0);
    ASSERT_TRUE(middle.hit);
    EXPECT_EQ(middle.mesh, "tube");
    EXPECT_NEAR(middle.mm.y, 18, 0.1) << "the front of the stronger ball, behind the weaker";
    EXPECT_TRUE(middle.labels.empty());
    EXPECT_FALSE(picked(looker, {1, 1}).hit);
    Scene dense = looker.opened(scene(0.5, balls));
    looker.wholeOf(looker.viewing->show(dense, false));
    const PickedPlace fog = picked(looker, glm::dvec2(kPicture) / 2.0);
    ASSERT_TRUE(fog.hit);
    EXPECT_EQ(fog.mesh, "");
    EXPECT_LT(fog.mm.y, 4) << "the fog's front, dimmed by the weaker ball";
}

TEST_F(MeshSession, ScenesOutliveTheVolumeTheyWereOpenedWith) {
    Scene kept;
    {
        Looker looker(true);
        kept = looker.opened(scene(0.001, R"([{"tube":{"points":[[20,24,18]],"radius":6}}])"));
        const auto still = looker.stillOf(looker.viewing->show(kept, false));
        const glm::vec4 p =
            still->image
                .pixels[static_cast<std::size_t>(kPicture.y / 2 * still->image.size.x + kPicture.x / 2)];
        EXPECT_EQ(p.a, 1);
        Scene other = kept;
        other.meshes[0].opacity = 0.5; // and without its shape, as from a file
        other.meshes[0].shape.reset();
        const auto half = looker.stillOf(looker.viewing->show(other, false));
        const glm::vec4 q =
            half->image
                .pixels[static_cast<std::size_t>(kPicture.y / 2 * half->image.size.x + kPicture.x / 2)];
        EXPECT_NEAR(q.a, 0.75, 0.02);
    }
    ASSERT_EQ(kept.meshes.size(), 1u);
    ASSERT_TRUE(kept.meshes[0].shape);
    EXPECT_EQ(kept.meshes[0].shape->parts(), 1u);
}

/// As a window has it that takes a mesh out again.
TEST_F(MeshSession, AMeshThatCannotBeReadIsRefused) {
    Looker looker(false);
    const Scene before = looker.opened(scene(0.01, "[]"));
    const Image drawn = looker.wholeOf(looker.viewing->show(before, false))->image;
    Scene with = before;
    with.meshes.push_back({folder_ / "broken.stl"});
    std::ofstream(folder_ / "broken.stl") << "solid\nfacet";
    const std::uint64_t asked = looker.viewing->show(with, false);
    ASSERT_TRUE(looker.comesTo([&] { return looker.viewing->state().refused >= asked; }));
    EXPECT_NE(looker.viewing->state().problem.find("broken.stl"), std::string::npos);
    looker.viewing->problemSeen();
    const Image again = looker.wholeOf(looker.viewing->show(before, false))->image;
    EXPECT_EQ(again.pixels, drawn.pixels);
}

} // namespace
} // namespace tessera::test
