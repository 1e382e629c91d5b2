// viewer/session/slice_frame.h: the three planes through a point, as pictures on a screen.
#pragma once

#include "core/base/volume.h"
#include "core/scene/mode.h"

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

namespace tessera {

/// Position of a plane on a picture.
struct SliceFrame {
    SlicePose pose;     // its point is at the picture's centre
    glm::ivec2 size{0}; // pixels
    double mmPerPixel = 1;

    /// The point at a pixel, mm; (0.5, 0.5) is the centre of the first.
    glm::dvec3 patientFromPicture(const glm::dvec2& pixel) const;
    /// The position of a point on the picture, projected along the plane's normal.
    glm::dvec2 pictureFromPatient(const glm::dvec3& mm) const;
};

/// The plane of an orientation through a point, with all of the volume's cross-section on the picture. It
/// stays in place on the picture when the point moves.
/// @param zoom  1: all of it; larger: nearer, around the point
SliceFrame sliceFrame(const VolumeInfo& info, Orientation orientation, const glm::dvec3& placeMm,
                      const glm::ivec2& size, double zoom = 1);

/// The content of the three planes.
struct SliceWish {
    glm::dvec3 placeMm{0};
    GreyWindow window;
    std::array<glm::ivec2, 3> sizes{}; // axial, coronal, sagittal, pixels; 0: not requested
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
    bool fine = false; // at the level of a pixel's size; else finer ones follow
    double value = 0;  // at the point, physical units; NaN outside the volume
};

} // namespace tessera
