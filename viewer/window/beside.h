// viewer/window/beside.h: Beside, another scan at the right of the open one, seen by the same camera with the
// same look: two dates of a patient, or two reconstructions. Places in both are linked.
#pragma once

#include "viewer/session/viewing.h"
#include "viewer/window/window_state.h"

#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>

namespace tessera {

/// What two scans have in common.
struct BesideLinks {
    enum class Places {
        coordinates, // of the patient: a place has the same in both
        middles      // the middle of one is the middle of the other
    };
    std::optional<Places> places; // none: placesOf() decides
    bool look = true;             // the function and the windows, where both have one unit
    bool cuts = true;
};

/// How places are linked: by coordinates where both scans have one frame of reference, or where the middle of
/// one lies in the other; else by middles, for by coordinates pictures would show little of one of them.
BesideLinks::Places placesOf(const VolumeInfo& from, const VolumeInfo& to, const BesideLinks& links);

/// From a place in one scan to the same in another, mm.
glm::dvec3 shiftBetween(const VolumeInfo& from, const VolumeInfo& to, const BesideLinks& links = {});

/// The scene of the other scan that goes with a scene: its camera, slice and cuts, moved by
/// shiftBetween(), its mode, light and look. Values of another unit keep their own function and window. Boxes
/// in voxels, meshes and labels of the scene are left out.
/// @param of     the volume of the scene
/// @param other  as it was opened
Scene sceneBeside(const Scene& scene, const VolumeInfo& of, const VolumeSeen& other,
                  const BesideLinks& links = {});

class Beside {
  public:
    Beside(std::unique_ptr<Viewing> viewing, std::filesystem::path path);

    /// Once a frame: takes news, and asks for the picture that goes with that of the desk. Problems are told
    /// at the desk.
    void update(WindowState& desk, const glm::ivec2& pictureSize);
    Viewing& viewing() { return *viewing_; }
    /// Null before it is open.
    const VolumeSeen* volume() const { return volume_.get(); }
    const ViewingState& state() const { return state_; }
    /// The camera of the scene that was asked for last; null before the first.
    const Camera* camera() const { return std::get_if<Camera>(&scene_.camera); }
    /// As Viewing::saveStill().
    void saveStill(const Scene& scene, const std::filesystem::path& file, const PictureMarks& marks,
                   PanelOfStills panel);
    /// That which goes with the desk's as it is now. Both volumes are open.
    Scene sceneNow(const WindowState& desk) const;
    /// The picked point of the current request.
    const std::optional<PickedPlace>& picked() const { return picked_; }
    /// True if nothing more will come: also where it cannot be opened.
    bool atRest() const;
    std::string name() const { return path_.stem().string(); }
    /// What it shows and how both are linked, or why it shows nothing; a sentence.
    std::string about(const WindowState& desk) const;

    const BesideLinks& links() const { return links_; }
    void setLinks(const BesideLinks& links);
    /// From a place in the desk's volume to the same in this one.
    glm::dvec3 shift(const WindowState& desk) const;

    /// The planes through the same place as those of the desk, of the same sizes.
    SliceWish planes(const WindowState& desk) const;
    /// True if they have the desk's window.
    bool sharesWindow(const WindowState& desk) const;
    /// The window of its planes where it is not shared.
    void setWindow(const GreyWindow& window) { window_ = window; }

    /// What is drawn over its picture in the window, and in saved ones.
    FigurePart overlay(const WindowState& desk) const;
    PictureMarks marks(const WindowState& desk) const;

  private:
    FigurePart ofThis(FigurePart part, const WindowState& desk) const;

    std::unique_ptr<Viewing> viewing_;
    std::filesystem::path path_;
    std::shared_ptr<const VolumeSeen> volume_;
    const VolumeSeen* of_ = nullptr; // the desk's volume that was asked for last
    BesideLinks links_;
    Scene scene_;
    GreyWindow window_;
    ViewingState state_;
    std::optional<PickedPlace> picked_;
    std::uint64_t pickedBefore_ = 0; // answers up to this number are of another picture
    bool opened_ = false, moving_ = false;
    std::uint64_t asked_ = 0,
                  wished_ = 0; // the desk's request that was passed on last, and the number it got here
    glm::ivec2 size_{0};
};

/// The part of the panel on both: how they are linked.
void besidePanel(WindowState& desk, Beside& beside);

} // namespace tessera
