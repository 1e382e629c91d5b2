// tests/support/pretended_viewing.h: a Viewing that draws nothing: it keeps what it was asked for, and
// answers as a test sets it.
#pragma once

#include "viewer/session/viewing.h"

#include <cstdio>
#include <string>
#include <vector>

namespace tessera::test {

inline std::string placeText(const glm::dvec3& mm) {
    char text[80];
    std::snprintf(text, sizeof text, "%.2f %.2f %.2f", mm.x, mm.y, mm.z);
    return text;
}

/// A scan of 40 x 50 x 60 voxels, in the middle of which the patient's origin lies, seen from the front.
inline std::shared_ptr<VolumeSeen> pretendedVolume(const glm::ivec2& pictureSize) {
    auto seen = std::make_shared<VolumeSeen>();
    seen->path = "/scans/chest.zarr";
    seen->info.extentVoxels = {40, 50, 60};
    seen->info.unit = "HU";
    seen->info.patientFromVoxel = glm::dmat4(1, 0, 0, 0, 0, 1.2, 0, 0, 0, 0, 2, 0, -20, -30, -60, 1);
    seen->info.remarks = {"the gantry was tilted"};
    seen->values.lowest = -1000;
    seen->values.highest = 2000;
    seen->volumes = {{seen->values, "HU"}};
    for (int n = 0; n < 32; ++n)
        seen->histogram.push_back(1000 / (1 + (n - 9) * (n - 9)));
    seen->scene.volumes.push_back(
        {"/scans/chest.zarr",
         TransferFunction::fromOpacity({{-200, 0}, {300, 0.3}, {1200, 0.8}},
                                       {{-200, {0.6, 0.1, 0.05}}, {1200, {1, 0.9, 0.7}}}, 1)});
    seen->scene.imageSize = pictureSize;
    Camera camera;
    camera.position = {60, -280, 90};
    camera.focalPoint = {0, 0, 0};
    camera.viewUp = {0, 0, 1};
    camera.viewAngle = 30;
    seen->scene.camera = camera;
    return seen;
}

class PretendedViewing final : public Viewing {
  public:
    std::vector<std::string> said; // what was asked for, in words; not the pictures and picks
    std::shared_ptr<VolumeSeen> seen;
    std::shared_ptr<const VolumeOffers> offered;
    std::vector<std::shared_ptr<const Thumbnail>> thumbnails;
    std::shared_ptr<ShownPicture> drawn;
    std::shared_ptr<ShownSlices> planes;
    std::optional<PickedPlace> answer; // to every question, with its number
    std::optional<DiscValues> disc;
    ViewingState now;
    LineState lineNow;
    LineWish lineWish;
    Scene asked;
    std::string notice;
    std::uint64_t shows = 0, picks = 0, lines = 0, discs = 0;
    bool moving = false;

    void open(const std::filesystem::path& path, const glm::ivec2& size, const VolumePick& pick) override {
        say("open " + path.filename().string() + " at " + std::to_string(size.x) + " x " +
            std::to_string(size.y) + ", series " + std::to_string(pick.series) + ", phase " +
            std::to_string(pick.phase) + (pick.resampleZ ? ", resampled" : "") +
            (pick.allowMissing ? ", with gaps" : "") + (pick.asVolume ? ", as a volume" : "") +
            (pick.inSameView ? ", in the same view" : ""));
    }
    std::shared_ptr<const VolumeOffers> offers() const override { return offered; }
    std::shared_ptr<const Thumbnail> thumbnail(std::size_t n) const override {
        return n < thumbnails.size() ? thumbnails[n] : nullptr;
    }
    std::shared_ptr<const VolumeSeen> volume() const override { return seen; }
    std::uint64_t show(const Scene& scene, bool isMoving) override {
        asked = scene;
        moving = isMoving;
        return ++shows;
    }
    std::shared_ptr<const ShownPicture> picture() const override { return drawn; }
    ViewingState state() const override { return now; }
    void showLevels(bool) override {}
    void showSlices(const SliceWish& w) override {
        char text[160];
        std::snprintf(text, sizeof text,
                      "planes through %s, C %.4g W %.4g, zoom %.3g, %d x %d, %d x %d, %d x %d",
                      placeText(w.placeMm).c_str(), w.window.centre, w.window.width, w.zoom, w.sizes[0].x,
                      w.sizes[0].y, w.sizes[1].x, w.sizes[1].y, w.sizes[2].x, w.sizes[2].y);
        say(text);
    }
    std::shared_ptr<const ShownSlices> slices() const override { return planes; }
    std::uint64_t pick(const glm::dvec2& place) override {
        pickedAt = place;
        ++picks;
        if (answer)
            answer->number = picks;
        return picks;
    }
    std::optional<PickedPlace> picked() const override { return answer; }
    std::uint64_t askValues(const Measurement& m) override {
        say("values in a circle of " + std::to_string(m.points.size()) + " places");
        return ++discs;
    }
    std::optional<DiscValues> discValues() const override { return disc; }
    std::uint64_t findLine(const LineWish& wish) override {
        lineWish = wish;
        std::string words = wish.seenAlong ? "coverage" : wish.tree ? "tree" : "line";
        for (const glm::dvec3& place : wish.places)
            words += ", " + placeText(place);
        if (wish.threshold)
            words += ", threshold " + std::to_string(std::lround(*wish.threshold));
        if (wish.seenAlong)
            words += " of width " + std::to_string(std::lround(1000 * wish.aspect)) +
                     (wish.bothWays ? ", both ways" : "");
        say(words);
        return ++lines;
    }
    void callOffLine() override { say("line called off"); }
    LineState line() const override { return lineNow; }
    void lookAhead(std::vector<Camera> next) override {
        say(std::to_string(next.size()) + " cameras ahead" +
            (next.empty() ? "" : ", to " + placeText(next.back().position)));
    }
    static std::string textOf(const PictureMarks& marks) {
        std::string text = marks.annotations.scaleBar ? " with a scale bar" : "";
        for (const LegendBar& bar : marks.legend)
            text += " with " + bar.title() + " from " + bar.textAt(0) + " to " + bar.textAt(1);
        return text;
    }
    void saveScreenshot(const std::filesystem::path& path, const PictureMarks& marks,
                        const std::vector<SavedPanel>& beside) const override {
        std::string words = "screenshot " + path.filename().string() + textOf(marks);
        for (const SavedPanel& panel : beside)
            words += ", and another" + textOf(panel.marks);
        say(words);
        panels = beside;
    }
    void saveStill(const Scene& scene, const std::filesystem::path& path, const PictureMarks& marks,
                   PanelOfStills panel) override {
        say("still " + path.filename().string() + " of " + std::to_string(scene.imageSize.x) + " x " +
            std::to_string(scene.imageSize.y) + textOf(marks) + (panel ? ", a panel" : ""));
        still = scene;
    }
    std::string takeNotice() override { return std::exchange(notice, {}); }
    void problemSeen() override { now.problem.clear(); }

    glm::dvec2 pickedAt{0};
    mutable std::vector<SavedPanel> panels; // of the last screenshot, beside its own
    Scene still;                            // the last that was saved

    void opened(const glm::ivec2& pictureSize) {
        seen = pretendedVolume(pictureSize);
        now.kind = ViewingState::Kind::open;
        drawn = std::make_shared<ShownPicture>();
        drawn->stage = Stage::still;
        drawn->camera = std::get<Camera>(seen->scene.camera);
        asked = seen->scene;
    }
    /// The picture of the last scene, if there are pictures; a camera by side is 400 mm away.
    void draw() {
        if (!drawn || drawn->asked == shows)
            return;
        drawn = std::make_shared<ShownPicture>(*drawn);
        drawn->asked = shows;
        now.pictures = shows;
        if (const auto* const view = std::get_if<FittedView>(&asked.camera)) {
            const ViewAxes axes = axesOf(*view);
            drawn->camera.position = 400.0 * axes.towards;
            drawn->camera.focalPoint = glm::dvec3(0);
            drawn->camera.viewUp = axes.up;
            drawn->camera.projection = view->projection;
        } else {
            drawn->camera = std::get<Camera>(asked.camera);
        }
    }

  private:
    /// The same again is said once.
    void say(const std::string& words) const {
        auto& all = const_cast<PretendedViewing*>(this)->said;
        if (all.empty() || all.back() != words)
            all.push_back(words);
    }
};

} // namespace tessera::test
