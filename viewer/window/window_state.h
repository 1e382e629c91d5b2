// viewer/window/window_state.h: WindowState, the state that all parts of the window share: the edited scene,
// its picture, and messages to the user.
#pragma once

#include "core/base/error.h"
#include "viewer/session/viewing.h"
#include "viewer/window/history.h"
#include "viewer/window/preset_shelf.h"
#include "viewer/window/settings.h"

#include <algorithm>
#include <chrono>
#include <deque>
#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace tessera {

using WindowClock = std::chrono::steady_clock;

/// A sentence for the user, for some seconds.
struct Message {
    std::string text;
    bool problem = false;
    WindowClock::time_point until;
};

/// Times between an input and the picture that answers it.
struct Latency {
    double lastMs = 0;
    std::deque<double> recentMs;                      // of pictures while something moved, at most 200
    std::deque<WindowClock::time_point> pictureTimes; // of the last second
    void drew(double ms, WindowClock::time_point now);
    /// Of recentMs; 0 where there is none.
    double percentileMs(double share) const;
    double picturesPerSecond(WindowClock::time_point now) const;
};

class WindowState {
  public:
    WindowState(Viewing& viewing, Settings& settings, const PresetShelf& presets)
        : viewing_(viewing), settings_(settings), presets_(presets) {}

    Viewing& viewing() { return viewing_; }
    Settings& settings() { return settings_; }

    /// Takes what is new from the viewing: another volume, picture, problem. Once a frame.
    void update();
    /// Null before a volume is open.
    const VolumeSeen* volume() const { return volume_.get(); }
    const ShownPicture* picture() const { return picture_.get(); }
    const ViewingState& state() const { return state_; }
    /// What was under the pointer, of the picture as it is asked now.
    const std::optional<PickedPlace>& picked() const { return picked_; }
    /// The number of the last wish, and whether there is a picture of it.
    std::uint64_t asked() const { return asked_; }
    bool isAnswered() const { return picture_ && picture_->asked >= asked_; }
    /// Whether it cannot be drawn: the message said why.
    bool isRefused() const { return asked_ != 0 && state_.refused >= asked_; }
    /// What was told last that went wrong with an open volume.
    const std::string& lastProblem() const { return lastProblem_; }
    const Latency& latency() const { return latency_; }

    const Scene& scene() const { return scene_; }
    const Camera& camera() const { return std::get<Camera>(scene_.camera); }
    const TransferFunction& function() const {
        return std::get<TransferFunction>(scene_.volumes.front().transferFunction);
    }
    /// Another scene from now on. Where its mode has nothing to draw it gets what it lacks, and that is told.
    /// @param moving  more of the kind is about to come
    /// @param fit     what shows is another: a camera that is fitted is fitted anew
    void setScene(const Scene& scene, bool moving, bool fit = false);
    /// The isosurface that is offered where none is asked for: where the function is half as opaque
    /// as it gets.
    Isosurface surfaceOffered() const;
    void setCamera(const Camera& camera, bool moving);
    /// From a side of the patient, or from where one looks, so that all that shows fits the picture. It does
    /// so now and, until a hand moves the camera, whenever the picture gets another size or another preset.
    /// Where a slice is looked at, a side turns the slice.
    void fitView(View side);
    void fitView();
    void setProjection(Projection projection);
    void setFunction(const TransferFunction& function, bool moving);
    /// The three planes beside the volume, and what is asked of them.
    const SliceWish& slices() const { return slices_; }
    void setSlices(const SliceWish& wish);
    /// Of the picture, pixels. Waits until the size has stayed for a moment.
    void setPictureSize(const glm::ivec2& size);
    /// An edit begins that undo() takes back.
    void beginEdit() { history_.begin(scene_); }
    void undo();
    void redo();
    const History& history() const { return history_; }
    /// The camera as it was when the volume was opened, for the size as it is.
    void resetCamera();
    /// Whether a picture has yet to tell where it is.
    bool isFitting() const { return fitAsked_ != 0 && !isRefused(); }
    /// Whether it is fitted, and no hand has moved it since.
    bool isFitted() const { return fitted_.has_value(); }

    /// @param pick  which of several volumes
    void open(const std::filesystem::path& path, const VolumePick& pick = {});
    /// What the last path offers to choose from; null: nothing, or it was put away.
    std::shared_ptr<const VolumeOffers> offers() const { return offers_ == dismissed_ ? nullptr : offers_; }
    std::shared_ptr<const Thumbnail> thumbnail(std::size_t offer) const { return viewing_.thumbnail(offer); }
    /// Opens an offer.
    /// @param phase  from 1, where one has to be chosen
    void choose(std::size_t offer, int phase = 0);
    void dismissOffers() { dismissed_ = offers_; }
    /// The picture as PNG with its manifest, the scene as JSON: into the folder where the program was
    /// started, named after the volume, with a number where the name is taken. Tells what came of it.
    /// @param name   another name or path; empty: none
    /// @param times  as many pixels along each side as are shown: more are drawn first, as a still
    void savePicture(const std::string& name = {}, int times = 1);
    void saveScene(const std::string& name = {});
    /// Of those that the user kept.
    std::vector<std::string> ownPresets() const { return presets_.names(); }
    /// The scene looks like a preset: a built-in one's function, or all that one of the user's or of a file
    /// says. Tells what of it cannot be shown. Throws Error or InputError.
    void takePreset(const std::string& nameOrFile);
    /// Keeps what the scene looks like under a name, or writes it to a file in a format. Throws likewise.
    void keepPreset(const std::string& name);
    void writePreset(const std::filesystem::path& file, const std::string& format);
    /// A measurement in words; of a circle, once they are known, with the values that it holds.
    std::string describe(const Measurement& measurement);
    /// The preset whose function the scene has; "its own" where that is none of those with a name.
    const std::string& presetName();
    void tell(const std::string& text, bool problem = false);
    /// Does it; what goes wrong is told.
    template <typename Act> void trying(const Act& act) {
        try {
            act();
        } catch (const Error& e) {
            tell(e.what(), true);
        }
    }
    const std::optional<Message>& message() const { return message_; }

    /// Whether a wish has been sent whose last word (not moving) is still owed; sends it when its time has
    /// come. Returns whether to look again soon.
    bool settle();
    /// Whether all that was asked has been sent, for good.
    bool hasAsked() const { return !owesRest_ && (wantedSize_ == scene_.imageSize || !volume_); }

    bool showPanels = true, showSlices = true, showHelp = false, showLevels = false, flying = false;
    bool savesScaleBar = false; // in pictures that are saved
    int enlargedPlane = -1;     // that lies alone beside the picture; -1: all three
    /// Of the width beside the panel, the planes'.
    double planesShare() const { return enlargedPlane < 0 ? planesShare_ : kEnlargedShare; }
    void setPlanesShare(double share) {
        planesShare_ = std::clamp(share, kLeastShare, kMostShare);
        enlargedPlane = -1;
    }
    bool showBrowser = false; // over an open volume; without one it shows anyway

  private:
    static constexpr double kEnlargedShare = 0.6, kLeastShare = 0.12, kMostShare = 0.8;
    /// @param fit  the camera anew, where it is a fitted one
    void send(bool moving, bool fit = false);
    std::uint64_t ask(bool moving);
    void takeFitted();
    void showSomething(const Scene& before);
    void takeDiscValues();
    void takeBack(Scene scene);
    Fit fitKind() const;
    template <typename Write> void save(const std::string& name, const char* extension, const Write& write);

    Viewing& viewing_;
    Settings& settings_;
    const PresetShelf& presets_;
    std::shared_ptr<const VolumeSeen> volume_;
    std::shared_ptr<const ShownPicture> picture_;
    std::shared_ptr<const VolumeOffers> offers_, dismissed_;
    std::optional<PickedPlace> picked_;
    ViewingState state_;
    std::string lastProblem_;
    Scene scene_;
    std::optional<FittedView> fitted_; // what the camera is fitted for; none: a hand or a path moved it
    std::uint64_t fitAsked_ = 0;       // the wish whose picture tells the fitted camera; 0: it is known
    struct Held {                      // the camera as a hand left it, and the picture's size then
        Camera camera;
        glm::ivec2 size{0};
    };
    std::optional<Held> held_; // none: fitted, or moved by a path
    History history_;
    SliceWish slices_;
    std::vector<std::pair<Measurement, DiscValues>> discs_; // that are known
    std::optional<Measurement> discAsked_;
    std::uint64_t discNumber_ = 0;
    std::string presetName_, taken_,
        takenText_; // of the wish presetOf_; a preset that was taken, its function
    std::uint64_t presetOf_ = 0;
    double planesShare_ = 0.28;
    std::optional<Message> message_;
    Latency latency_;
    bool owesRest_ = false;
    WindowClock::time_point lastInput_, askedAt_;
    std::uint64_t asked_ = 0, pickedBefore_ = 0; // pickedBefore_: answers up to it are of another picture
    bool askedMoving_ = false;
    glm::ivec2 wantedSize_{0};
    WindowClock::time_point sizeChanged_;
};

} // namespace tessera
