// viewer/window/beside.h: Beside, another scan at the right of the open one, seen by the same camera with the
// same look: two dates of a patient, or two reconstructions.
#pragma once

#include "viewer/session/viewing.h"
#include "viewer/window/picture_view.h"
#include "viewer/window/window_state.h"

#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <memory>

namespace tessera {

/// From a place in one scan to the same in another, mm. Nothing where both have the same frame of reference;
/// else from the middle of one to the middle of the other, for then nothing says how they lie to one another.
glm::dvec3 shiftBetween(const VolumeInfo& from, const VolumeInfo& to);

/// The scene of the other scan that goes with a scene: its camera, slice and cuts, moved by
/// shiftBetween(), its mode, light and look. Values of another unit keep their own function and window. Boxes
/// in voxels, meshes and labels of the scene are left out.
/// @param of     the volume of the scene
/// @param other  as it was opened
Scene sceneBeside(const Scene& scene, const VolumeInfo& of, const VolumeSeen& other);

class Beside {
  public:
    Beside(std::unique_ptr<Viewing> viewing, std::filesystem::path path);

    /// Once a frame: takes news, and asks for the picture that goes with that of the desk.
    void update(const WindowState& desk, const glm::ivec2& pictureSize);
    Viewing& viewing() { return *viewing_; }
    /// Null before it is open.
    const VolumeSeen* volume() const { return volume_.get(); }
    const ViewingState& state() const { return state_; }
    /// True if nothing more will come: also where it cannot be opened.
    bool atRest() const;
    /// What it shows and how both are linked, or why it shows nothing; a sentence.
    std::string about(const WindowState& desk) const;

  private:
    std::unique_ptr<Viewing> viewing_;
    std::filesystem::path path_;
    std::shared_ptr<const VolumeSeen> volume_;
    const VolumeSeen* of_ = nullptr; // the desk's volume that was asked for last
    ViewingState state_;
    bool opened_ = false, moving_ = false;
    std::uint64_t asked_ = 0; // the desk's request that was passed on last
    glm::ivec2 size_{0};
};

/// Over the right half of the picture: a line at its left edge, and about().
void drawBeside(const Beside& beside, const WindowState& desk, const Area& area);

} // namespace tessera
