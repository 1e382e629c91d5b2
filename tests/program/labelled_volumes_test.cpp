// tests/program/labelled_volumes_test.cpp: scenes of several volumes: messages on labels name the volume that
// has them, and --hide-table is of all.
#include "tests/support/program_fixture.h"

#include <nlohmann/json.hpp>

namespace tessera::test {
namespace {

using ::testing::ElementsAre;

class LabelledVolumes : public Program {
  protected:
    void SetUp() override {
        ASSERT_EQ(run("phantom ramp --size 12x10x8 -o a.zarr").exitCode, 0);
        std::string voxels; // about all of the phantom, and more
        for (int i = 0; i < 8 * 8 * 8; ++i)
            voxels += "1 ";
        write("l.nrrd", "NRRD0004\ntype: uchar\ndimension: 3\nspace: left-posterior-superior\nsizes: 8 8 8\n"
                        "space directions: (64,0,0) (0,64,0) (0,0,64)\nkinds: domain domain domain\n"
                        "encoding: ascii\nspace origin: (-256,-256,-256)\n\n" +
                            voxels + "\n");
    }
    /// Volumes with these labels each; "": none.
    std::string scene(const std::vector<std::string>& labels, const std::string& more = "") {
        std::string volumes;
        for (const std::string& own : labels)
            volumes += std::string(volumes.empty() ? "" : ",") +
                       R"({"path":"a.zarr","transferFunction":"auto")" +
                       (own.empty() ? "" : R"(,"labels":{"path":"l.nrrd",)" + own + "}") + "}";
        write("s.json",
              R"({"tesseraScene":1,"image":{"size":[16,16]},"volumes":[)" + volumes + "]" + more + "}");
        return "render s.json -o a.png --engine native --no-check";
    }
};

TEST_F(LabelledVolumes, MessagesNameTheVolume) {
    const std::string good = R"("look":"plain")", bad = R"("show":["nowhere"])";
    const std::string own = R"("each":[{"of":"1","transferFunction":"auto"}])";
    const std::string slice = R"(,"mode":"slice","slice":{"plane":"axial"})";
    const Outcome drawn = run(scene({good, good, good}));
    ASSERT_EQ(drawn.exitCode, 0) << drawn.problems;
    expectRefused(scene({bad}), {"volumes[0].labels.show", "nowhere"});
    expectRefused(scene({"", bad}), {"volumes[1].labels.show", "nowhere"});
    expectRefused(scene({good, good, bad}), {"volumes[2].labels.show", "nowhere"});
    expectRefused(scene({good, good, bad}, slice), {"volumes[2].labels.show", "nowhere"});
    expectRefused(scene({good, bad}, R"(,"mode":"maximum")"), {"volumes[1].labels.show", "nowhere"});
    // Labels of a function of their own are drawn as volumes behind the others.
    ASSERT_EQ(run(scene({own, ""})).exitCode, 0);
    expectRefused(scene({own + "," + bad, ""}), {"volumes[0].labels.show"});
    expectRefused(scene({"", own + "," + bad, own}), {"volumes[1].labels.show"});
}

TEST_F(LabelledVolumes, PresetsThatAreNoneNameTheirOption) {
    write("bad.json", "{}");
    const std::string drawn = "render a.zarr --add a.zarr -o a.png ";
    expectRefused(drawn + "--preset bad.json", {"tessera: --preset: ", "bad.json"});
    expectRefused(drawn + "--add-preset bad.json", {"tessera: --add-preset: ", "bad.json"});
    expectRefused(drawn + "--labels l.nrrd --label-preset 1=bad.json",
                  {"tessera: --label-preset: ", "bad.json"});
}

TEST_F(LabelledVolumes, PresetsOfLabelsComeToTheirLabels) {
    const Outcome drawn =
        run("render a.zarr --labels l.nrrd --label-preset 1=skin --unit HU -o a.png --size 16x16 --engine "
            "native --no-check --json");
    ASSERT_EQ(drawn.exitCode, 0) << drawn.problems;
    const auto each = nlohmann::json::parse(drawn.out)["scene"]["volumes"][0]["labels"]["each"];
    ASSERT_EQ(each.size(), 1u);
    EXPECT_EQ(each[0]["of"], "1");
    EXPECT_THAT(each[0]["transferFunction"].dump(), testing::HasSubstr("skin"));
}

TEST_F(LabelledVolumes, TheTableIsOneOptionOfAll) {
    const auto hidden = [&](const std::string& arguments) {
        const Outcome outcome = run(arguments + " --json");
        EXPECT_EQ(outcome.exitCode, 0) << outcome.problems;
        const auto scene = nlohmann::json::parse(outcome.out)["scene"];
        std::vector<std::string> values;
        for (const auto& volume : scene["volumes"])
            values.push_back(volume.value("hideTable", "no"));
        return values;
    };
    const std::string two = "render a.zarr --add a.zarr -o a.png --size 16x16 --engine native --no-check";
    EXPECT_THAT(hidden(two), ElementsAre("auto", "auto"));
    EXPECT_THAT(hidden(two + " --hide-table no"), ElementsAre("no", "no"));
    EXPECT_THAT(hidden(scene({"", ""})), ElementsAre("no", "no"));
    EXPECT_THAT(hidden(scene({"", ""}) + " --hide-table auto"), ElementsAre("auto", "auto"));
    EXPECT_THAT(hidden(two + " --hide-table no --set volumes[1].hideTable=auto"), ElementsAre("no", "auto"));
}

} // namespace
} // namespace tessera::test
