// viewer/session/view_session.cpp: see view_session.h. Its side of the board: what others ask and see; a
// thread does the work (session_thread.h).
#include "viewer/session/view_session.h"

#include "core/base/address.h"
#include "core/base/error.h"
#include "viewer/session/session_board.h"
#include "viewer/session/session_thread.h"
#include "viewer/session/shown_picture.h"

#include <optional>
#include <utility>
#include <variant>
#include <vector>

namespace tessera {
namespace {

namespace fs = std::filesystem;

class ViewSession final : public Viewing {
  public:
    explicit ViewSession(const ViewSessionOptions& options) : thread_(options, board_) {}

    void open(const fs::path& path, const glm::ivec2& pictureSize, const VolumePick& pick) override {
        board_.ask([&](SessionWishes& wishes, SessionNews& news) {
            wishes.toOpen = {path, pictureSize, pick};
            wishes.toShow.reset();
            news.offers.reset();
            news.thumbnails.clear();
            news.state.kind = ViewingState::Kind::opening;
            news.state.what = "opening " + shownName(path);
            news.state.share = 0;
            news.state.problem.clear();
            thread_.callOffOpening(); // of one before: this one cannot have begun
        });
    }
    std::shared_ptr<const VolumeOffers> offers() const override {
        return board_.look([](const SessionNews& news) { return news.offers; });
    }
    std::shared_ptr<const Thumbnail> thumbnail(std::size_t offer) const override {
        return board_.look([&](const SessionNews& news) {
            return offer < news.thumbnails.size() ? news.thumbnails[offer] : nullptr;
        });
    }
    std::shared_ptr<const VolumeSeen> volume() const override {
        return board_.look([](const SessionNews& news) { return news.volume; });
    }
    std::uint64_t show(const Scene& scene, bool moving) override {
        if (const auto* const camera = std::get_if<Camera>(&scene.camera))
            camera->validate("camera");
        std::uint64_t number = 0;
        board_.ask([&](SessionWishes& wishes, SessionNews& news) {
            number = ++news.wishes;
            wishes.toShow = {scene, moving, number};
        });
        return number;
    }
    std::shared_ptr<const ShownPicture> picture() const override {
        return board_.look([](const SessionNews& news) { return news.picture; });
    }
    ViewingState state() const override {
        return board_.look([](const SessionNews& news) {
            ViewingState state = news.state;
            state.atRest = state.atRest && news.saved == news.saves;
            if (news.slices && state.problem.empty())
                state.problem = news.slices->takeProblem();
            if (state.kind == ViewingState::Kind::opening) {
                const Progress::Stage stage = news.opening ? news.opening->now() : Progress::Stage{};
                if (!stage.what.empty())
                    state.what = stage.what, state.share = stage.share;
            }
            return state;
        });
    }
    void showLevels(bool shown) override {
        board_.ask([&](SessionWishes& wishes, SessionNews& news) {
            if (shown == news.levelsShown)
                return;
            news.levelsShown = wishes.stateAsked = shown;
            if (!shown)
                news.state.levels.reset();
        });
    }
    void showSlices(const SliceWish& wish) override {
        board_.tell([&](SessionNews& news) {
            if (news.slices)
                news.slices->show(wish);
        });
    }
    std::shared_ptr<const ShownSlices> slices() const override {
        return board_.look([](const SessionNews& news) {
            return news.slices ? news.slices->shown() : std::shared_ptr<const ShownSlices>();
        });
    }
    std::uint64_t pick(const glm::dvec2& place) override {
        std::uint64_t number = 0;
        board_.ask([&](SessionWishes& wishes, SessionNews& news) {
            number = ++news.questions;
            wishes.question = {place, number};
        });
        return number;
    }
    std::optional<PickedPlace> picked() const override {
        return board_.look([](const SessionNews& news) { return news.picked; });
    }
    std::uint64_t askValues(const Measurement& circle) override {
        std::uint64_t number = 0;
        board_.ask([&](SessionWishes& wishes, SessionNews& news) {
            number = ++news.questions;
            wishes.disc = {circle, number};
        });
        return number;
    }
    std::optional<DiscValues> discValues() const override {
        return board_.look([](const SessionNews& news) { return news.disc; });
    }
    std::uint64_t findLine(const LineWish& wish) override {
        std::uint64_t number = 0;
        board_.ask([&](SessionWishes& wishes, SessionNews& news) {
            number = ++news.lines;
            wishes.line = {wish, number};
            news.line.searching = true;
            news.line.what = "searching the line";
            news.line.share = 0;
        });
        return number;
    }
    void callOffLine() override {
        board_.ask([](SessionWishes& wishes, SessionNews&) { wishes.lineCalledOff = true; });
    }
    LineState line() const override {
        return board_.look([](const SessionNews& news) {
            LineState line = news.line;
            if (news.lineProgress) {
                const Progress::Stage stage = news.lineProgress->now();
                if (!stage.what.empty())
                    line.what = stage.what, line.share = stage.share;
            }
            return line;
        });
    }
    void lookAhead(std::vector<Camera> next) override {
        board_.ask([&](SessionWishes& wishes, SessionNews&) { wishes.ahead = std::move(next); });
    }
    void saveScreenshot(const fs::path& path, const PictureMarks& marks,
                        const std::vector<SavedPanel>& beside) const override {
        std::vector<SavedPanel> panels = {{picture(), marks}};
        panels.insert(panels.end(), beside.begin(), beside.end());
        const auto ram = board_.look([](const SessionNews& news) { return news.savingRam; });
        for (const SavedPanel& panel : panels)
            if (!panel.picture || !ram)
                throw InputError("there is no picture to save");
        savePictures(path, panels, *ram);
    }
    void saveStill(const Scene& scene, const fs::path& path, const PictureMarks& marks,
                   PanelOfStills panel) override {
        std::optional<SessionWishes::Save> before; // its figure is given up after the lock
        board_.ask([&](SessionWishes& wishes, SessionNews& news) {
            before = std::exchange(wishes.save,
                                   SessionWishes::Save{scene, path, marks, std::move(panel), ++news.saves});
        });
    }
    std::string takeNotice() override {
        std::string notice;
        board_.tell([&](SessionNews& news) { notice.swap(news.notice); });
        return notice;
    }
    void problemSeen() override {
        board_.tell([](SessionNews& news) { news.state.problem.clear(); });
    }

  private:
    SessionBoard board_;
    SessionThread thread_; // last: it uses the board
};

} // namespace

std::unique_ptr<Viewing> makeViewSession(const ViewSessionOptions& options) {
    return std::make_unique<ViewSession>(options);
}

} // namespace tessera
