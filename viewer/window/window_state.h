// viewer/window/window_state.h: WindowState, the state that all parts of the window share: the edited scene,
// its picture, and messages to the user.
#pragma once

#include "core/base/error.h"
#include "core/scene/scene.h"
#include "viewer/session/viewing.h"
#include "viewer/window/run_window.h"
#include "viewer/window/settings.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <deque>
#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace tessera {

class Beside;

// Undo and redo of scenes.

/// A continuous edit (dragging a point) is one step: call begin() once at its start.
class History {
  public:
    /// Records the scene before an edit. Clears redo.
    void begin(const Scene& before) {
        undone_.clear();
        done_.push_back(before);
        if (done_.size() > kMost)
            done_.erase(done_.begin());
    }
    /// Forgets the last edit.
    void drop() {
        if (!done_.empty())
            done_.pop_back();
    }
    bool canUndo() const { return !done_.empty(); }
    bool canRedo() const { return !undone_.empty(); }
    /// The scene before the last edit.
    /// @param now  the current scene, kept for redo()
    Scene undo(const Scene& now) { return step(done_, undone_, now); }
    Scene redo(const Scene& now) { return step(undone_, done_, now); }

  private:
    static constexpr std::size_t kMost = 200;
    static Scene step(std::vector<Scene>& from, std::vector<Scene>& to, const Scene& now) {
        if (from.empty())
            return now;
        to.push_back(now);
        Scene scene = std::move(from.back());
        from.pop_back();
        return scene;
    }
    std::vector<Scene> done_, undone_;
};

using WindowClock = std::chrono::steady_clock;

/// A sentence for the user, for some seconds.
struct Message {
    std::string text;
    bool problem = false;
    WindowClock::time_point until;
};

/// Latencies from an input to the picture that answers it.
struct Latency {
    double lastMs = 0;
    std::deque<double> recentMs;                      // of interactive pictures, at most 200
    std::deque<WindowClock::time_point> pictureTimes; // of the last second
    void drew(double ms, WindowClock::time_point now);
    /// Of recentMs; 0 if empty.
    double percentileMs(double share) const;
    double picturesPerSecond(WindowClock::time_point now) const;
};

class WindowState {
  public:
    WindowState(Viewing& viewing, Settings& settings, const PresetShelf& presets)
        : viewing_(viewing), settings_(settings), presets_(presets) {}

    Viewing& viewing() { return viewing_; }
    /// The scan at the right of the open one; null: none.
    Beside* beside() const { return beside_; }
    void setBeside(Beside* beside) { beside_ = beside; }
    Settings& settings() { return settings_; }

    /// Takes new results of the viewing: volume, picture, problem. Once a frame.
    void update();
    /// Null before a volume is open.
    const VolumeSeen* volume() const { return volume_.get(); }
    const ShownPicture* picture() const { return picture_.get(); }
    const ViewingState& state() const { return state_; }
    /// The picked point of the current request.
    const std::optional<PickedPlace>& picked() const { return picked_; }
    /// The number of the last request, and whether its picture is there.
    std::uint64_t asked() const { return asked_; }
    bool isAnswered() const { return picture_ && picture_->asked >= asked_; }
    /// True if it cannot be drawn: the message gives the reason.
    bool isRefused() const { return asked_ != 0 && state_.refused >= asked_; }
    /// The last error of an open volume.
    const std::string& lastProblem() const { return lastProblem_; }
    const Latency& latency() const { return latency_; }

    const Scene& scene() const { return scene_; }
    const Camera& camera() const { return std::get<Camera>(scene_.camera); }
    const TransferFunction& function() const {
        return std::get<TransferFunction>(scene_.volumes.front().transferFunction);
    }
    /// Sets the scene. If its mode has nothing to draw, the missing part is added, with a message.
    /// @param moving  more changes follow soon
    /// @param fit  the visible content changes: a fitted camera is fitted again
    void setScene(const Scene& scene, bool moving, bool fit = false);
    /// The default isosurface: at half the function's largest opacity.
    Isosurface surfaceOffered() const;
    void setCamera(const Camera& camera, bool moving);
    /// Fits the camera to all that is visible, from a side of the patient or in the current direction. Until
    /// the user moves the camera, it is fitted again when size or preset change. In mode slice a side turns
    /// the slice.
    void fitView(View side);
    void fitView();
    void setProjection(Projection projection);
    void setFunction(const TransferFunction& function, bool moving);
    /// The labels beside the volume; call beginEdit() before the first of an edit.
    const Labels& labels() const { return scene_.volumes.front().labels; }
    void setLabels(const Labels& labels, bool moving);
    /// Adds the mesh of a file; an edit. A file that cannot be read is taken out again, with its problem.
    void addMesh(const std::filesystem::path& file);
    /// The three planes beside the volume, and requests for them.
    const SliceWish& slices() const { return slices_; }
    void setSlices(const SliceWish& wish);
    /// Sets the picture's size, pixels. Waits until the size is stable.
    void setPictureSize(const glm::ivec2& size);
    /// Begins an edit for undo().
    void beginEdit() { history_.begin(scene_); }
    void undo();
    void redo();
    const History& history() const { return history_; }
    /// The camera as opened, for the current size.
    void resetCamera();
    /// True while the fitted camera is not known yet.
    bool isFitting() const { return fitAsked_ != 0 && !isRefused(); }
    /// True if it is fitted, and the user has not moved it since.
    bool isFitted() const { return fitted_.has_value(); }

    /// A volume, labels of the open one, or its mesh.
    /// @param pick  which of several volumes
    void open(const std::filesystem::path& path, const VolumePick& pick = {});
    /// The volumes of the last path; null: nothing to choose, or dismissed.
    std::shared_ptr<const VolumeOffers> offers() const { return offers_ == dismissed_ ? nullptr : offers_; }
    std::shared_ptr<const Thumbnail> thumbnail(std::size_t offer) const { return viewing_.thumbnail(offer); }
    /// Opens an offer.
    /// @param phase  from 1, if one must be chosen
    void choose(std::size_t offer, int phase = 0);
    void dismissOffers() { dismissed_ = offers_; }
    /// Shows another phase of the volume, from 1, and leaves all else as it is. One that it does not have:
    /// nothing.
    void showPhase(int phase);
    /// The next one or, with -1, the one before; behind the last the first.
    void stepPhase(int by);
    /// Saves the picture as PNG with its manifest, or the scene as JSON, in the folder where the program was
    /// started. The name is that of the volume, with a number if it exists. Reports the outcome.
    /// @param name   another name or path; empty: none
    /// @param times  factor on the shown size: a larger picture is first drawn as a still
    void savePicture(const std::string& name = {}, int times = 1);
    void saveScene(const std::string& name = {});
    /// The pictures as they are shown, of both scans where there are two, to this very file; stills of so
    /// many times their size, which are drawn first. Throw Error or InputError.
    void writeShown(const std::filesystem::path& file);
    void writeStill(const std::filesystem::path& file, int times);
    /// Of those that the user kept.
    std::vector<std::string> ownPresets() const { return presets_.names(); }
    /// Applies a preset: the function of a built-in one, or all settings of a user's or a file's. Reports
    /// unsupported settings. Throws Error or InputError.
    void takePreset(const std::string& nameOrFile);
    /// Keeps the scene's appearance under a name, or writes it to a file in a format. Throws likewise.
    void keepPreset(const std::string& name);
    void writePreset(const std::filesystem::path& file, const std::string& format);
    /// A measurement in words; for a circle with its values, once they are known.
    std::string describe(const Measurement& measurement);
    /// The preset whose function the scene has; "its own" for another function.
    const std::string& presetName();
    void tell(const std::string& text, bool problem = false);
    /// Runs it; errors are reported.
    template <typename Act> void trying(const Act& act) {
        try {
            act();
        } catch (const Error& e) {
            tell(e.what(), true);
        }
    }
    const std::optional<Message>& message() const { return message_; }

    /// Sends the final request after a series with `moving`, when it is due. Returns true if it is still
    /// pending.
    bool settle();
    /// True if all requests have been sent, none as moving.
    bool hasAsked() const { return !owesRest_ && (wantedSize_ == scene_.imageSize || !volume_); }

    bool showPanels = true, showSlices = true, showHelp = false, showLevels = false, flying = false;
    bool savesScaleBar = false, savesLegend = false; // in pictures that are saved
    std::optional<bool> showLegend;                  // none: where colours need it
    bool showsLegend() const {
        return volume_ && showLegend.value_or(scene_.annotations.legend || needsLegend(scene_));
    }
    /// Of the scene as it is.
    std::vector<LegendBar> legend() const;
    /// The scene's annotations, whose words name the phase of a volume that is open.
    Annotations wordsOf(const VolumeSeen* volume) const;
    PictureMarks marks() const;
    /// What is drawn over the picture in the window: a scale bar and the cube always.
    FigurePart overlay() const;
    int enlargedPlane = -1; // shown alone beside the picture; -1: all three
    /// The planes' share of the width beside the panel.
    double planesShare() const { return enlargedPlane < 0 ? planesShare_ : kEnlargedShare; }
    void setPlanesShare(double share) {
        planesShare_ = std::clamp(share, kLeastShare, kMostShare);
        enlargedPlane = -1;
    }
    bool showBrowser = false; // over an open volume; without one it is always shown

  private:
    static constexpr double kEnlargedShare = 0.6, kLeastShare = 0.12, kMostShare = 0.8;
    /// @param fit  the camera again, if it is a fitted one
    void send(bool moving, bool fit = false);
    std::uint64_t ask(bool moving);
    void takeFitted();
    void takePhase();
    void showSomething(const Scene& before);
    void takeDiscValues();
    void settleMesh();
    void takeBack(Scene scene);
    Fit fitKind() const;
    template <typename Write> void save(const std::string& name, const char* extension, const Write& write);

    Viewing& viewing_;
    Beside* beside_ = nullptr;
    Settings& settings_;
    const PresetShelf& presets_;
    std::shared_ptr<const VolumeSeen> volume_;
    std::shared_ptr<const ShownPicture> picture_;
    std::shared_ptr<const VolumeOffers> offers_, dismissed_;
    std::optional<PickedPlace> picked_;
    ViewingState state_;
    std::string lastProblem_;
    Scene scene_;
    std::optional<FittedView>
        fitted_;                 // view to which the camera is fitted; none: the user or a path moved it
    std::uint64_t fitAsked_ = 0; // the request whose picture has the fitted camera; 0: it is known
    struct Held {                // the camera as the user left it, and the picture's size then
        Camera camera;
        glm::ivec2 size{0};
    };
    std::optional<Held> held_; // none: fitted, or moved by a path
    History history_;
    std::filesystem::path meshAdded_; // whose picture is not there yet; "": none
    std::uint64_t meshAsked_ = 0;     // the request for it
    SliceWish slices_;
    std::vector<std::pair<Measurement, DiscValues>> discs_; // that are known
    std::optional<Measurement> discAsked_;
    std::uint64_t discNumber_ = 0;
    std::string presetName_, taken_,
        takenText_; // of request presetOf_; an applied preset, its function
    std::uint64_t presetOf_ = 0;
    double planesShare_ = 0.28;
    std::optional<Message> message_;
    Latency latency_;
    bool owesRest_ = false;
    WindowClock::time_point lastInput_, askedAt_;
    std::uint64_t asked_ = 0,
                  pickedBefore_ = 0; // pickedBefore_: answers up to this number are of another picture
    bool askedMoving_ = false;
    int phaseAsked_ = 0; // the last
    glm::ivec2 wantedSize_{0};
    WindowClock::time_point sizeChanged_;
};

} // namespace tessera
