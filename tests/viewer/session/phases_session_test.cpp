// tests/viewer/session/phases_session_test.cpp: phases of a file in a session: another one is shown in the
// same view.
#include "core/base/program_folders.h"
#include "tests/support/looker.h"

#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <glm/geometric.hpp>

namespace tessera::test {
namespace {

namespace fs = std::filesystem;

constexpr int kEdge = 24, kTimes = 3;

/// A ball that grows, of unsigned bytes.
void writePhases(const fs::path& file) {
    std::ofstream out(file, std::ios::binary);
    out << "NRRD0004\ntype: uint8\ndimension: 4\nspace: left-posterior-superior\nsizes: 24 24 24 3\n"
           "space directions: (1,0,0) (0,1,0) (0,0,1) none\nkinds: domain domain domain time\n"
           "encoding: raw\n\n";
    for (int time = 0; time < kTimes; ++time)
        for (int n = 0; n < kEdge * kEdge * kEdge; ++n) {
            const glm::dvec3 at(n % kEdge, n / kEdge % kEdge, n / kEdge / kEdge);
            out.put(
                static_cast<char>(glm::distance(at, glm::dvec3(11.5)) < 4 + 3 * time ? 100 + 50 * time : 0));
        }
}

class PhasesSession : public ::testing::Test {
  protected:
    PhasesSession() {
        ::setenv("XDG_CACHE_HOME", (folder / "cache").c_str(), 1);
        writePhases(path);
    }
    ~PhasesSession() override { ::unsetenv("XDG_CACHE_HOME"); }
    static ViewSessionOptions options() {
        ViewSessionOptions made;
        made.stills = false;
        made.engine = EngineKind::native;
        made.ramBytes = kRamBytes;
        made.gpuBytes = kGpuBytes;
        made.common.quiet = true;
        return made;
    }
    static bool isOpen(const Looker& looker, int phase) {
        const auto volume = looker.viewing->volume();
        return volume && volume->phase == phase;
    }
    const ScratchFolder folder;
    const fs::path path = folder / "a.nrrd";
};

TEST_F(PhasesSession, AnotherPhaseIsShownInTheSameView) {
    Looker looker(options());
    VolumePick pick;
    pick.phase = 2;
    looker.viewing->open(path, kPicture, pick);
    ASSERT_TRUE(looker.comesTo([&] { return isOpen(looker, 2); }));
    auto volume = looker.viewing->volume();
    EXPECT_EQ(volume->phases, (std::vector<std::string>{"time 1", "time 2", "time 3"}));
    EXPECT_EQ(volume->values.highest, 150);
    Scene scene = volume->scene;
    Camera camera = std::get<Camera>(scene.camera);
    camera.position += glm::dvec3(7, -3, 2);
    scene.camera = camera;
    scene.cuts.boxes.push_back({glm::dvec3(0), glm::dvec3(12), CropBox::Space::voxels, Keep::inside});
    looker.wholeOf(looker.viewing->show(scene, false));
    for (const int phase : {3, 1, 2}) {
        VolumePick other;
        other.phase = phase;
        other.inSameView = true;
        looker.viewing->open(path, kPicture, other);
        ASSERT_TRUE(looker.comesTo([&] { return isOpen(looker, phase); }));
        volume = looker.viewing->volume();
        EXPECT_EQ(volume->values.highest, 50 + 50 * phase);
        EXPECT_EQ(volume->phases.size(), 3U);
        Scene expected = scene;
        expected.volumes.front().source.phase = phase;
        EXPECT_EQ(sceneJson(volume->scene), sceneJson(expected)) << phase;
        EXPECT_EQ(looker.viewing->state().problem, "");
    }
    VolumePick none;
    none.phase = 4;
    none.inSameView = true;
    looker.viewing->open(path, kPicture, none);
    ASSERT_TRUE(looker.comesTo([&] { return !looker.viewing->state().problem.empty(); }));
    EXPECT_NE(looker.viewing->state().problem.find("between 1 and 3"), std::string::npos);
    EXPECT_TRUE(isOpen(looker, 2)) << "it stays";
    EXPECT_EQ(looker.viewing->offers(), nullptr);
}

} // namespace
} // namespace tessera::test
