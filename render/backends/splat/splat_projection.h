// render/backends/splat/splat_projection.h: SplatView: from places in voxels to the camera's axes and pixels,
// and the footprint of a kernel there (docs/sampling.md, "Splats"). Bases are computed in double, so that
// floats from there on stay small.
#pragma once

#include "core/base/volume.h"
#include "core/scene/camera.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vec2.hpp>

namespace tessera {

/// A footprint in pixels, before filters.
struct Footprint {
    glm::vec2 at{0};              // its middle; x right, y down
    float xx = 0, xy = 0, yy = 0; // variance
    float area = 0;               // pixels^2 per mm^2 of the plane at its depth: |J| f^2
};

struct SplatView {
    bool perspective = true;
    double scale = 1;         // pixels: of the image plane at depth 1, or per mm of a parallel camera
    glm::dvec2 middle{0};     // of the picture, pixels
    glm::dmat3 axes{1};       // mm to the right, down and forward of the picture per voxel
    glm::dvec3 origin{0};     // of voxel (0,0,0)'s corner, in these axes from the eye
    glm::dvec3 eye{0};        // voxels; a parallel camera's position
    glm::dvec3 forward{0};    // unit, patient space
    double widening = 1;      // most of |u|^2 / u2^2: 1 + 2 tan^2(angle / 2), as the paper has it
    glm::dvec3 deviations{1}; // singular values of axes, ascending: mm per voxel

    glm::dvec3 place(const glm::dvec3& voxel) const { return axes * voxel + origin; }
    /// A kernel of deviation 1 along voxels, as mm in the picture's axes.
    /// @param deviation  voxels
    glm::mat3 kernel(double deviation) const { return glm::mat3(axes * deviation); }
};

/// Singular values of a matrix, ascending: roots of the eigenvalues of A^T A in closed form (Smith 1961).
inline glm::dvec3 singularValues(const glm::dmat3& a) {
    const glm::dmat3 m = glm::transpose(a) * a;
    const double mean = (m[0][0] + m[1][1] + m[2][2]) / 3;
    const glm::dmat3 k = m - glm::dmat3(mean);
    double p = 0;
    for (int i = 0; i < 3; ++i)
        p += glm::dot(k[i], k[i]) / 6;
    p = std::sqrt(p);
    if (!(p > 1e-14 * mean))
        return glm::dvec3(std::sqrt(mean));
    const double r = glm::clamp(glm::determinant(k / p) / 2, -1.0, 1.0), third = glm::radians(120.0);
    const double angle = std::acos(r) / 3;
    const auto root = [&](double turn) { return std::sqrt(std::max(mean + 2 * p * std::cos(turn), 0.0)); };
    const double most = root(angle), least = root(angle + third);
    return {least, std::sqrt(std::max(3 * mean - most * most - least * least, 0.0)), most};
}

inline SplatView splatView(const Camera& camera, const VolumeInfo& info, const glm::ivec2& imageSize) {
    SplatView view;
    const glm::dmat3 patientFromCamera = tessera::patientFromCamera(camera); // right, up, towards the viewer
    const glm::dmat3 picture(patientFromCamera[0], -patientFromCamera[1], -patientFromCamera[2]);
    const glm::dmat3 pictureFromPatient = glm::transpose(picture);
    view.perspective = camera.projection == Projection::perspective;
    const double tangent = std::tan(glm::radians(camera.viewAngle) / 2);
    view.scale = imageSize.y / (2 * (view.perspective ? tangent : camera.parallelScale));
    view.middle = 0.5 * glm::dvec2(imageSize);
    view.axes = pictureFromPatient * glm::dmat3(info.patientFromVoxel);
    view.origin = pictureFromPatient * (glm::dvec3(info.patientFromVoxel[3]) - camera.position);
    view.eye = glm::dvec3(glm::inverse(info.patientFromVoxel) * glm::dvec4(camera.position, 1));
    view.forward = picture[2];
    view.widening = view.perspective ? 1 + 2 * tangent * tangent : 1;
    view.deviations = singularValues(view.axes);
    return view;
}

/// @param u       its middle in the picture's axes, mm; u.z > 0 with perspective
/// @param kernel  SplatView::kernel()
inline Footprint footprintOf(bool perspective, float scale, const glm::vec2& middle, const glm::vec3& u,
                             const glm::mat3& kernel) {
    Footprint f;
    const glm::vec3 row0(kernel[0].x, kernel[1].x, kernel[2].x), row1(kernel[0].y, kernel[1].y, kernel[2].y),
        row2(kernel[0].z, kernel[1].z, kernel[2].z);
    float factor = scale;
    glm::vec3 right = row0, down = row1;
    if (perspective) {
        const float inverse = 1 / u.z, x = u.x * inverse, y = u.y * inverse;
        factor *= inverse;
        right -= x * row2;
        down -= y * row2;
        f.at = middle + scale * glm::vec2(x, y);
        f.area = factor * factor * std::sqrt(1 + x * x + y * y);
    } else {
        f.at = middle + scale * glm::vec2(u);
        f.area = factor * factor;
    }
    const float squared = factor * factor;
    f.xx = squared * glm::dot(right, right);
    f.xy = squared * glm::dot(right, down);
    f.yy = squared * glm::dot(down, down);
    return f;
}

} // namespace tessera
