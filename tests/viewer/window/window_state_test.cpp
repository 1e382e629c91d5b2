// tests/viewer/window/window_state_test.cpp: edits at the window's desk, without a window or a volume's
// picture: each of them, what is measured as well, is taken back and done again as one step.
#include "viewer/window/tools.h"
#include "viewer/window/window_state.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

/// An open volume of which nothing is ever drawn.
class StillVolume final : public Viewing {
  public:
    StillVolume() {
        auto seen = std::make_shared<VolumeSeen>();
        seen->info.extentVoxels = glm::ivec3(16);
        seen->values.highest = 1;
        seen->scene.volumes.push_back({"v.zarr", TransferFunction::fromOpacity({{0, 0}, {1, 1}}, {}, 1)});
        seen->scene.camera = Camera();
        volume_ = std::move(seen);
    }
    void open(const std::filesystem::path&, const glm::ivec2&, const VolumePick&) override {}
    std::shared_ptr<const VolumeOffers> offers() const override { return {}; }
    std::shared_ptr<const Thumbnail> thumbnail(std::size_t) const override { return {}; }
    std::shared_ptr<const VolumeSeen> volume() const override { return volume_; }
    std::uint64_t show(const Scene&, bool) override { return ++wishes_; }
    std::shared_ptr<const ShownPicture> picture() const override { return {}; }
    ViewingState state() const override { return {}; }
    void showLevels(bool) override {}
    void showSlices(const SliceWish&) override {}
    std::shared_ptr<const ShownSlices> slices() const override { return {}; }
    std::uint64_t pick(const glm::dvec2&) override { return 1; }
    std::optional<PickedPlace> picked() const override { return {}; }
    std::uint64_t askValues(const Measurement&) override { return 1; }
    std::optional<DiscValues> discValues() const override { return {}; }
    std::uint64_t findLine(const LineWish&) override { return 1; }
    void callOffLine() override {}
    LineState line() const override { return {}; }
    void lookAhead(std::vector<Camera>) override {}
    void saveScreenshot(const std::filesystem::path&, bool) const override {}
    void saveStill(const Scene&, const std::filesystem::path&, bool) override {}
    std::string takeNotice() override { return {}; }
    void problemSeen() override {}

  private:
    std::shared_ptr<const VolumeSeen> volume_;
    std::uint64_t wishes_ = 0;
};

TEST(WindowState, WhatIsMeasuredIsTakenBackAndDoneAgain) {
    StillVolume volume;
    Settings settings;
    const PresetShelf presets;
    WindowState desk(volume, settings, presets);
    desk.update();
    ASSERT_TRUE(desk.volume());
    Tools tools;
    std::vector<std::string> states = {sceneJson(desk.scene())}; // after as many edits
    for (const auto& [tool, points] :
         {std::pair{Tools::Tool::distance, 2}, {Tools::Tool::angle, 3}, {Tools::Tool::circle, 3}}) {
        tools.take(tool);
        for (int n = 0; n < points; ++n)
            EXPECT_TRUE(tools.placed(desk, {n, n * n, states.size()}));
        EXPECT_EQ(desk.scene().measurements.size(), states.size());
        EXPECT_FALSE(tools.placed(desk, glm::dvec3(0))) << "it is whole";
        states.push_back(sceneJson(desk.scene()));
    }
    for (std::size_t left = states.size() - 1; left-- > 0;) {
        ASSERT_TRUE(desk.history().canUndo());
        desk.undo();
        EXPECT_EQ(sceneJson(desk.scene()), states[left]) << left;
    }
    EXPECT_FALSE(desk.history().canUndo());
    for (std::size_t done = 1; done < states.size(); ++done) {
        desk.redo();
        EXPECT_EQ(sceneJson(desk.scene()), states[done]) << done;
    }
    EXPECT_FALSE(desk.history().canRedo());
}

} // namespace
} // namespace tessera
