// core/scene/mesh.h: SceneMesh: a surface besides the volume, a file's triangles or contours, or a tube, and
// how it shows (docs/sampling.md, "Meshes").
#pragma once

#include "core/base/names.h"
#include "core/scene/transfer_function.h" // MaterialResponse

#include <filesystem>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

class Shape; // render/geometry/shape.h

/// Axes of a file's coordinates, mm: those of DICOM, or x to the right and y to the front, as 3D Slicer and
/// NIfTI have them.
enum class MeshSpace { lps, ras };
template <> const NameTable<MeshSpace>& namesOf<MeshSpace>();

/// How the contours of a structure set are drawn: as tubes, or joined to closed surfaces.
enum class ContourStyle { lines, surface };
template <> const NameTable<ContourStyle>& namesOf<ContourStyle>();

/// All points no further than a radius from a line through points: a needle, a catheter, a path.
struct Tube {
    static constexpr std::size_t kMostPoints = 65536;
    std::vector<glm::dvec3> points; // one at least; patient space (LPS), mm
    double radiusMm = 1;            // above 0
    bool operator==(const Tube&) const = default;
};

/// Light grey: the colour of surfaces without one.
constexpr glm::dvec3 kMeshColour{0.8};

struct SceneMesh {
    static constexpr std::size_t kMost = 64; // of a scene

    static constexpr std::size_t kMostPatterns = 4096;

    std::filesystem::path path = {}; // a file of triangles or a DICOM structure set; "" there is a tube
    std::optional<Tube> tube = {};
    std::vector<std::string> rois = {};          // of a structure set, as patterns of labels are; none: all
    ContourStyle contours = ContourStyle::lines; // of a structure set
    double lineRadiusMm = 0.5;                   // of contours that are tubes
    double surfaceStepMm = 0; // of the grid on which contours become a surface; 0: by their size and memory
    double surfaceGapMm =
        0; // the largest distance of planes of contours that a surface joins; 0: 3.5 medians
    /// Linear light, [0,1], not premultiplied. None: that of the shape, or light grey.
    std::optional<glm::dvec3> colour = {};
    double opacity = 1;                            // [0,1], of the surface itself, at any angle
    std::optional<MaterialResponse> material = {}; // none: the scene's shading
    MeshSpace space = MeshSpace::lps;              // of the file
    bool sameFrame = false; // a structure set is taken though its frame of reference is another
    bool show = true;
    bool clipped = true; // by the scene's cuts
    /// What was read or made of it; null until then. Not in files.
    std::shared_ptr<const Shape> shape = {};

    bool isDrawn() const { return show && opacity > 0; }
    std::string name() const { return path.empty() ? "tube" : path.filename().string(); }
    /// What the shape follows from.
    bool isSameShape(const SceneMesh& other) const {
        return path == other.path && tube == other.tube && space == other.space && rois == other.rois &&
               contours == other.contours && lineRadiusMm == other.lineRadiusMm &&
               surfaceStepMm == other.surfaceStepMm && surfaceGapMm == other.surfaceGapMm &&
               sameFrame == other.sameFrame;
    }
    /// As files have them: the shape follows from the rest.
    bool operator==(const SceneMesh& other) const {
        return isSameShape(other) && colour == other.colour && opacity == other.opacity &&
               material == other.material && show == other.show && clipped == other.clipped;
    }
};

} // namespace tessera
