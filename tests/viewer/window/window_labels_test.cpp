// tests/viewer/window/window_labels_test.cpp: the panel of labels and the click that shows one alone: what
// they draw and change in the scene, step by step, is what is recorded; many labels, and none.
#include "tests/support/window_record.h"

#include <chrono>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tessera::test {
namespace {

using ::testing::ElementsAre;

std::shared_ptr<const LabelList> someLabels() {
    return std::make_shared<const LabelList>(LabelList{{1, "spleen", "organs", {0.5, 0.1, 0.1}, true},
                                                       {2, "rib", "", {0.8, 0.8, 0.6}, true},
                                                       {3, "liver", "organs", {0.4, 0.1, 0.05}, true},
                                                       {8, "aorta", "vessels", {0.8, 0, 0}, true},
                                                       {9, "tail", "", {0, 0.5, 0}, false},
                                                       {70, "8", "vessels", {0, 0, 0.9}, true}});
}

template <typename Window> class WithLabels : public Window {
  public:
    explicit WithLabels(std::shared_ptr<const LabelList> labels = someLabels()) {
        this->viewing.seen->labels = std::move(labels);
        this->viewing.seen->scene.volumes[0].labels.path = "/scans/chest.seg.nrrd";
    }
    Labels labels() const { return this->desk.labels(); }
    /// Left of a name.
    glm::dvec2 beside(const std::string& name, double units) const {
        glm::dvec2 at = this->placeOf(name);
        for (const Drawn& d : this->drawn)
            if (d.words == name)
                at.x = static_cast<double>(d.left) - units;
        return at;
    }
    void eye(const std::string& name) {
        this->step("eye of " + name, [&] { this->click(beside(name, 31)); });
    }
    void colour(const std::string& name) {
        this->step("colour of " + name, [&] {
            this->click(beside(name, 13));
            this->frame();
        });
    }
};

TEST(WindowDrawn, PanelOfLabels) {
    WithLabels<PanelWindow> w;
    w.records = [](const Drawn& d) { return d.list.find("labels") != std::string::npos; };
    w.step("open", [] {});
    w.eye("liver");
    EXPECT_THAT(w.labels().hide, ElementsAre("3"));
    w.eye("organs (2)");
    EXPECT_THAT(w.labels().hide, ElementsAre("1", "3")) << "those of a group that shows in part are hidden";
    w.eye("organs (2)");
    EXPECT_TRUE(w.labels().hide.empty());
    w.eye("aorta");
    EXPECT_THAT(w.labels().hide, ElementsAre("08")) << "a label has the name 8";
    w.clicked("show all");
    w.clicked("only@2"); // spleen, behind the button of its group
    EXPECT_THAT(w.labels().show, ElementsAre("1"));
    EXPECT_FALSE(showsUnlabelled(w.labels()));
    w.eye("rib");
    EXPECT_THAT(w.labels().show, ElementsAre("1", "2"));
    w.clicked("only@1");
    EXPECT_THAT(w.labels().show, ElementsAre("1", "3"));
    w.clicked("only@1");
    EXPECT_TRUE(w.labels().show.empty() && showsUnlabelled(w.labels())) << "all again";
    w.clicked("tissue without a label");
    EXPECT_EQ(w.labels().unlabelled, false);
    w.step("close a group", [&] { w.click(w.beside("organs (2)", 52)); });
    w.step("open it", [&] { w.click(w.beside("organs (2)", 52)); });
    w.step("search", [&] {
        w.clickOn("search");
        w.type("VESS");
    });
    EXPECT_TRUE(w.shows("aorta"));
    EXPECT_FALSE(w.shows("liver"));
    w.step("search for nothing", [&] {
        w.clickOn("VESS");
        w.type("x");
    });
    compareWithRecord(w, "panel-labels");
}

TEST(WindowDrawn, LooksOfLabels) {
    WithLabels<PanelWindow> w;
    w.records = [](const Drawn& d) { return d.list.find("opup") != std::string::npos; };
    w.step("open", [] {});
    w.colour("rib");
    w.dragged("R:231", -60);
    w.dragged("1.000 per mm@0", -40);
    ASSERT_EQ(w.labels().each.size(), 1u);
    EXPECT_EQ(w.labels().each[0].of, "2");
    EXPECT_TRUE(w.labels().each[0].colour && w.labels().each[0].opacity);
    w.step("the look is there", [&] { w.click({900, 2900}); });
    w.colour("organs (2)");
    w.dragged("1.000 per mm@0", -60);
    EXPECT_EQ(w.labels().each.size(), 3u);
    w.clicked("as at first");
    EXPECT_EQ(w.labels().each.size(), 1u);
    w.chosen("solid", "tint");
    EXPECT_EQ(w.labels().look, LabelLook::tint);
    w.dragged("1.00@1", -40);
    EXPECT_LT(w.labels().opacity.value_or(1), 0.9);
    compareWithRecord(w, "label-looks");
}

TEST(WindowLabels, HaveAFillAndAnOutlineOverPlanes) {
    WithLabels<PanelWindow> w;
    w.step("open", [] {});
    const Scene before = w.desk.scene();
    w.dragged("0.50", 60);
    EXPECT_GT(w.labels().fill.value_or(0), 0.55);
    w.dragged("1.0 pixels", 60);
    EXPECT_GT(w.labels().outline, 1.2);
    w.desk.undo();
    EXPECT_EQ(w.labels().outline, 1);
    w.desk.undo();
    EXPECT_EQ(sceneJson(w.desk.scene()), sceneJson(before));
}

TEST(WindowLabels, AClickShowsWhatIsThereAlone) {
    WithLabels<PictureWindow> w;
    w.desk.showSlices = false;
    w.step("open", [] {});
    const glm::dvec2 at(300, 200);
    const auto clicked = [&](std::vector<std::uint32_t> labels, bool hit = true) {
        w.viewing.answer = PickedPlace{0, hit, {5, 6, 7}, {25, 30, 33}, 123.4, 0, std::move(labels)};
        w.rest();
        w.keyed(&ImGuiIO::KeyShift, [&] { w.keyed(&ImGuiIO::KeyCtrl, [&] { w.click(at); }); });
        w.frame();
    };
    const Scene before = w.desk.scene();
    clicked({3});
    EXPECT_THAT(w.labels().show, ElementsAre("3"));
    EXPECT_EQ(std::get<Camera>(w.desk.scene().camera), std::get<Camera>(before.camera)) << "it moves nothing";
    clicked({3});
    EXPECT_EQ(w.labels(), before.volumes[0].labels);
    clicked({3, 8});
    EXPECT_THAT(w.labels().show, ElementsAre("3", "08"));
    w.desk.undo();
    w.desk.undo();
    EXPECT_THAT(w.labels().show, ElementsAre("3"));
    w.desk.undo();
    EXPECT_EQ(sceneJson(w.desk.scene()), sceneJson(before));
    EXPECT_FALSE(w.desk.history().canUndo());
    clicked({});
    EXPECT_EQ(w.desk.message()->text, "no label is there");
    clicked({}, false);
    EXPECT_EQ(w.desk.message()->text, "nothing is visible there");
    EXPECT_FALSE(w.desk.history().canUndo());

    w.viewing.answer->hit = true;
    w.viewing.answer->labels = {3, 8};
    w.moveTo(at + glm::dvec2(9, 9));
    std::this_thread::sleep_for(std::chrono::milliseconds(150));
    w.frame();
    w.frame();
    EXPECT_TRUE(w.shows("7.0 mm, liver, aorta"));
}

TEST(WindowLabels, AreMentionedWhereThereAreAny) {
    const auto mentions = [](auto& w) {
        w.desk.showHelp = true;
        w.step("help", [] {});
        const bool inHelp = w.shows("Ctrl Shift + click"), inPanel = w.shows("Labels");
        EXPECT_EQ(inHelp, inPanel);
        return inHelp;
    };
    {
        PanelWindow plain;
        EXPECT_FALSE(mentions(plain));
    }
    WithLabels<PanelWindow> w;
    EXPECT_TRUE(mentions(w));
    EXPECT_FALSE(w.shows("draws no labels"));
    Scene scene = w.desk.scene();
    scene.mode = Mode::maximum;
    w.desk.setScene(scene, false);
    w.frame();
    EXPECT_TRUE(w.shows("mode maximum draws no labels"));
    w.viewing.seen = pretendedVolume({400, 300}); // another volume, without labels
    w.desk.showHelp = false;
    w.frame();
    w.frame();
    EXPECT_FALSE(mentions(w));
}

TEST(WindowLabels, WithoutLabelsThatClickIsOneWithShift) {
    const glm::dvec2 at(300, 200);
    PictureWindow plain;
    plain.step("open", [] {});
    const Scene camera = plain.desk.scene();
    plain.keyed(&ImGuiIO::KeyShift,
                [&] { plain.keyed(&ImGuiIO::KeyCtrl, [&] { plain.drag(at, at + glm::dvec2(20, 20)); }); });
    EXPECT_NE(std::get<Camera>(plain.desk.scene().camera), std::get<Camera>(camera.camera))
        << "without labels it is a drag with Shift";
}

/// Of thousands only those in sight are drawn, and a frame takes no longer for that.
TEST(WindowLabels, ThousandsScroll) {
    auto many = std::make_shared<LabelList>();
    for (std::uint32_t n = 0; n < 5000; ++n)
        many->push_back({n + 1, "structure " + std::to_string(n), n % 3 == 0 ? "thirds" : "", glm::vec3(0.5),
                         n % 7 != 0});
    WithLabels<PanelWindow> w(many);
    w.step("open", [] {});
    const auto rows = [&] {
        return std::count_if(w.drawn.begin(), w.drawn.end(),
                             [](const Drawn& d) { return d.words.starts_with("structure "); });
    };
    EXPECT_GT(rows(), 5);
    EXPECT_LT(rows(), 40);
    EXPECT_TRUE(w.shows("structure 3"));
    const auto began = std::chrono::steady_clock::now();
    for (int n = 0; n < 50; ++n)
        w.wheel(w.placeOf("structure"), -5);
    const double ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - began).count();
    std::printf("%.2f ms a frame\n", ms / 150);
    EXPECT_LT(ms / 150, 20);
    EXPECT_FALSE(w.shows("structure 3"));
    EXPECT_LT(rows(), 40);
    w.clickOn("tissue without a label");
    EXPECT_FALSE(showsUnlabelled(w.labels()));
    w.clickOn("search");
    w.type("structure 4997");
    w.frame(); // the list's place follows
    EXPECT_EQ(rows(), 2) << "what is searched, and its row";
    w.clickOn("only@0");
    EXPECT_THAT(w.labels().show, ElementsAre("4998"));

    auto edits = std::chrono::steady_clock::now();
    std::vector<std::size_t> half;
    for (std::size_t n = 0; n < 5000; n += 2)
        half.push_back(n);
    const Labels hidden = withShown(*many, withAllShown(w.labels()), half, false);
    EXPECT_EQ(labelStates(*many, hidden)[4].shows, false);
    EXPECT_EQ(labelStates(*many, hidden)[5].shows, true);
    std::printf("%.0f ms for an edit of 2500 of 5000\n",
                std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - edits).count());
}

} // namespace
} // namespace tessera::test
