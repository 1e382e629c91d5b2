// viewer/window/desk.h: what all parts of the window share: the scene as it is edited, what is shown of it,
// and what the user is told.
#pragma once

#include "core/error.h"
#include "viewer/session/viewing.h"
#include "viewer/window/history.h"
#include "viewer/window/preset_shelf.h"
#include "viewer/window/settings.h"

#include <chrono>
#include <deque>
#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <string>

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

class Desk {
  public:
    Desk(Viewing& viewing, Settings& settings, const PresetShelf& presets)
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
    const Latency& latency() const { return latency_; }

    const Scene& scene() const { return scene_; }
    const Camera& camera() const { return std::get<Camera>(scene_.camera); }
    const TransferFunction& function() const {
        return std::get<TransferFunction>(scene_.volumes.front().transferFunction);
    }
    /// Another scene from now on. @param moving  more of the kind is about to come
    void setScene(const Scene& scene, bool moving);
    void setCamera(const Camera& camera, bool moving);
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

    void open(const std::filesystem::path& path);
    /// The picture as PNG with its manifest, the scene as JSON: into the folder where the program was
    /// started, named after the volume, with a number where the name is taken. Tells what came of it.
    void savePicture();
    void saveScene();
    /// Of those that the user kept.
    std::vector<std::string> ownPresets() const { return presets_.names(); }
    /// The scene looks like a preset: a built-in one's function, or all that one of the user's or of a file
    /// says. Tells what of it cannot be shown. Throws Error or InputError.
    void takePreset(const std::string& nameOrFile);
    /// Keeps what the scene looks like under a name, or writes it to a file in a format. Throws likewise.
    void keepPreset(const std::string& name);
    void writePreset(const std::filesystem::path& file, const std::string& format);
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

  private:
    void send(bool moving);
    template <typename Write> void save(const char* what, const char* extension, const Write& write);

    Viewing& viewing_;
    Settings& settings_;
    const PresetShelf& presets_;
    std::shared_ptr<const VolumeSeen> volume_;
    std::shared_ptr<const ShownPicture> picture_;
    std::optional<PickedPlace> picked_;
    ViewingState state_;
    Scene scene_;
    History history_;
    SliceWish slices_;
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
