// tests/viewer/window/window_meshes_test.cpp: meshes that are dropped on the window, and their panel: what
// they draw and change in the scene, step by step, is what is recorded.
#include "tests/support/window_record.h"
#include "viewer/session/file_kind.h"

#include <algorithm>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tessera::test {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

void writeText(const fs::path& path, const std::string& text) {
    std::ofstream(path, std::ios::binary) << text;
}

std::string structureSetHead(const std::string& kind) {
    return std::string(128, '\0') + "DICM" + std::string("\x02\0\x02\0UI\x1e\0", 8) + kind +
           std::string(40, '\0');
}

TEST(FileKinds, MeshesByNamesAndFirstBytes) {
    const ScratchFolder scratch;
    const fs::path folder = scratch.path();
    for (const char* name : {"a.stl", "b.PLY", "c.obj", "d.gltf", "e.Glb"}) {
        writeText(folder / name, "anything");
        EXPECT_TRUE(meansMesh(folder / name)) << name;
        EXPECT_FALSE(meansStructureSet(folder / name)) << name;
    }
    fs::create_directories(folder / "folder.stl");
    for (const char* name : {"none.stl", "folder.stl"})
        EXPECT_FALSE(meansMesh(folder / name)) << name;
    const std::string kind = "1.2.840.10008.5.1.4.1.1.481.3";
    writeText(folder / "rs", structureSetHead(kind));
    EXPECT_TRUE(meansMesh(folder / "rs") && meansStructureSet(folder / "rs"));
    writeText(folder / "longer", structureSetHead(kind + "0"));
    writeText(folder / "deeper", structureSetHead(kind + ".1"));
    writeText(folder / "ct", structureSetHead("1.2.840.10008.5.1.4.1.1.2"));
    writeText(folder / "words", std::string(132, ' ') + kind + std::string(4, '\0'));
    writeText(folder / "short", "DICM");
    for (const char* name : {"longer", "deeper", "ct", "words", "short"})
        EXPECT_FALSE(meansMesh(folder / name)) << name;
}

class DroppedMeshes : public testing::Test {
  protected:
    DroppedMeshes() { writeText(stl, "solid"); }
    const ScratchFolder scratch;
    const fs::path stl = scratch.path() / "liver.stl";
    PanelWindow w;
};

TEST_F(DroppedMeshes, AreAnEditOfTheScene) {
    w.frame();
    const Scene before = w.desk.scene();
    w.desk.open(stl);
    ASSERT_EQ(w.desk.scene().meshes.size(), 1u);
    EXPECT_EQ(w.desk.scene().meshes[0].path, stl);
    EXPECT_EQ(w.viewing.asked.meshes, w.desk.scene().meshes);
    EXPECT_TRUE(std::none_of(w.viewing.said.begin(), w.viewing.said.end(),
                             [](const std::string& said) { return said.find("open") == 0; }));
    ASSERT_TRUE(w.desk.message());
    EXPECT_THAT(w.desk.message()->text, HasSubstr("liver.stl is a mesh of the scene"));
    w.desk.open(stl);
    EXPECT_EQ(w.desk.scene().meshes.size(), 1u);
    EXPECT_THAT(w.desk.message()->text, HasSubstr("already"));
    w.desk.undo();
    EXPECT_EQ(w.desk.scene().meshes, before.meshes);
    w.desk.redo();
    EXPECT_EQ(w.desk.scene().meshes.size(), 1u);
    Scene full = w.desk.scene();
    while (full.meshes.size() < SceneMesh::kMost)
        full.meshes.push_back({"/elsewhere/" + std::to_string(full.meshes.size()) + ".stl"});
    w.desk.setScene(full, false);
    writeText(scratch.path() / "more.stl", "solid");
    w.desk.open(scratch.path() / "more.stl");
    EXPECT_TRUE(w.desk.message()->problem);
    EXPECT_EQ(w.desk.scene().meshes.size(), SceneMesh::kMost);
}

TEST_F(DroppedMeshes, ThatCannotBeReadLeaveTheSceneAsItWas) {
    w.frame();
    w.desk.open(stl);
    ASSERT_EQ(w.desk.scene().meshes.size(), 1u);
    w.viewing.now.refused = w.desk.asked();
    w.viewing.now.problem = "liver.stl: expected triangles, found none";
    w.desk.update();
    EXPECT_TRUE(w.desk.scene().meshes.empty());
    EXPECT_TRUE(w.viewing.asked.meshes.empty()) << "it is drawn again";
    EXPECT_FALSE(w.desk.history().canUndo());
    EXPECT_FALSE(w.desk.history().canRedo());
    ASSERT_TRUE(w.desk.message());
    EXPECT_THAT(w.desk.message()->text, HasSubstr("expected triangles"));
    const std::uint64_t asked = w.desk.asked();
    w.desk.update();
    EXPECT_EQ(w.desk.asked(), asked);
}

TEST_F(DroppedMeshes, ContoursOfStructureSetsBecomeSurfaces) {
    const fs::path set = scratch.path() / "plan.dcm";
    writeText(set, structureSetHead("1.2.840.10008.5.1.4.1.1.481.3"));
    w.frame();
    w.desk.open(stl);
    w.desk.open(set);
    ASSERT_EQ(w.desk.scene().meshes.size(), 2u);
    w.frame();
    w.frame();
    const auto look = [&](const std::string& name) {
        const auto at = std::ranges::find(w.drawn, name, &Drawn::words);
        ASSERT_NE(at, w.drawn.end());
        const double left = at->left; // a click draws anew
        w.click({left - 13, w.placeOf(name).y});
        w.frame();
        w.frame();
    };
    look("liver.stl");
    EXPECT_FALSE(w.shows("contours"));
    w.click({900, 2900});
    w.frame();
    look("plan.dcm");
    ASSERT_TRUE(w.shows("contours"));
    w.chosen("lines", "surface");
    EXPECT_EQ(w.desk.scene().meshes[1].contours, ContourStyle::surface);
    EXPECT_EQ(w.viewing.asked.meshes[1].contours, ContourStyle::surface);
    w.desk.undo();
    EXPECT_EQ(w.desk.scene().meshes[1].contours, ContourStyle::lines);
}

TEST(DroppedFiles, WithoutAVolumeAreOpened) {
    const ScratchFolder scratch;
    writeText(scratch.path() / "liver.stl", "solid");
    PanelWindow w;
    w.viewing.seen.reset();
    w.desk.update();
    w.desk.open(scratch.path() / "liver.stl");
    EXPECT_TRUE(std::any_of(w.viewing.said.begin(), w.viewing.said.end(),
                            [](const std::string& said) { return said.find("open liver.stl") == 0; }));
}

TEST(DroppedFiles, ThatAreTakenAsLabelsCanBeOpenedAsVolumes) {
    PanelWindow w;
    w.frame();
    auto labelled = std::make_shared<VolumeSeen>(*w.viewing.seen);
    labelled->labels = std::make_shared<const LabelList>(LabelList{{1, "spleen", "", {0.5, 0.1, 0.1}, true}});
    labelled->eitherFile = labelled->scene.volumes[0].labels.path = "/scans/organs.nii.gz";
    w.viewing.seen = labelled;
    w.frame();
    ASSERT_TRUE(w.desk.message());
    EXPECT_THAT(w.desk.message()->text, HasSubstr("organs.nii.gz has whole numbers on the lattice"));
    w.frame();
    w.clickOn("open as a volume");
    EXPECT_THAT(w.viewing.said, ::testing::Contains(HasSubstr("open organs.nii.gz")));
    EXPECT_THAT(w.viewing.said, ::testing::Contains(HasSubstr("as a volume")));
}

TEST(WindowDrawn, PanelOfMeshes) {
    PanelWindow w;
    Scene& scene = w.viewing.seen->scene;
    scene.meshes = {{"/scans/liver.stl"}, {"/scans/vessels.ply"}};
    scene.meshes[1].colour = glm::dvec3(0.6, 0.05, 0.05);
    scene.meshes.push_back({});
    scene.meshes[2].tube = Tube{{{0, 0, 0}, {0, 0, 50}}, 2};
    const auto besides = [&](const std::string& name, double units) {
        glm::dvec2 at = w.placeOf(name);
        for (const Drawn& d : w.drawn)
            if (d.words == name)
                at.x = static_cast<double>(d.left) - units;
        return at;
    };
    w.records = [](const Drawn& d) {
        return d.words == "Meshes" || d.words.find(".stl") != std::string::npos ||
               d.words.find(".ply") != std::string::npos || d.words == "tube" ||
               d.list.find("opup") != std::string::npos;
    };
    w.step("open", [] {});
    w.step("eye of liver.stl", [&] { w.click(besides("liver.stl", 31)); });
    EXPECT_FALSE(w.desk.scene().meshes[0].show);
    w.step("undo", [&] { w.desk.undo(); });
    EXPECT_TRUE(w.desk.scene().meshes[0].show);
    w.step("colour of vessels.ply", [&] {
        w.click(besides("vessels.ply", 13));
        w.frame();
    });
    w.dragged("1.00@0", -60);
    EXPECT_LT(w.desk.scene().meshes[1].opacity, 0.9);
    w.dragged("R:", -40);
    EXPECT_NE(w.desk.scene().meshes[1].colour, glm::dvec3(0.6, 0.05, 0.05));
    w.clicked("colour as at first");
    EXPECT_FALSE(w.desk.scene().meshes[1].colour);
    w.step("the look is there", [&] { w.click({900, 2900}); });
    w.clicked("x@1");
    ASSERT_EQ(w.desk.scene().meshes.size(), 2u);
    EXPECT_EQ(w.desk.scene().meshes[0].name(), "vessels.ply");
    w.step("undo", [&] { w.desk.undo(); });
    EXPECT_EQ(w.desk.scene().meshes.size(), 3u);
    compareWithRecord(w, "panel-meshes");
}

} // namespace
} // namespace tessera::test
