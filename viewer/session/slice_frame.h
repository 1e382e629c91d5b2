// viewer/session/slice_frame.h: the three planes through a point, as they lie on a screen.
#pragma once

#include "core/base/volume.h"
#include "core/scene/mode.h"

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

namespace tessera {

/// Where a plane lies on a picture.
struct SliceFrame {
    SlicePose pose;     // its point is what the picture's middle shows
    glm::ivec2 size{0}; // pixels
    double mmPerPixel = 1;

    /// The place of a pixel, mm; (0.5, 0.5) is the middle of the first.
    glm::dvec3 patientFromPicture(const glm::dvec2& pixel) const;
    /// Where a place lies on the picture, along the plane's normal.
    glm::dvec2 pictureFromPatient(const glm::dvec3& mm) const;
};

/// The plane of an orientation through a place, so that all of the volume's plane is on the picture. It stays
/// where it is on the picture as the place moves.
/// @param zoom  1: all of it; larger: nearer, around the place
SliceFrame sliceFrame(const VolumeInfo& info, Orientation orientation, const glm::dvec3& placeMm,
                      const glm::ivec2& size, double zoom = 1);

/// What one finds on the three planes.
struct SliceWish {
    glm::dvec3 placeMm{0};
    GreyWindow window;
    std::array<glm::ivec2, 3> sizes{}; // axial, coronal, sagittal, pixels; 0: none is wanted
    double zoom = 1;
    bool operator==(const SliceWish&) const = default;
};

struct ShownSlice {
    SliceFrame frame;
    int level = 0;
    std::vector<std::uint32_t> display; // of the frame's size
};
struct ShownSlices {
    std::array<ShownSlice, 3> planes;
    SliceWish wish;
    bool fine = false; // as fine as a pixel shows; else finer ones follow
    double value = 0;  // at the place, physical units; NaN outside the volume
};

} // namespace tessera
