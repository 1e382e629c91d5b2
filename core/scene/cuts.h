// core/scene/cuts.h: cuts of a volume before it is drawn: boxes, planes, and prisms drawn as outlines on a
// picture. Several cuts combine: only what each of them keeps is drawn.
#pragma once

#include "core/scene/camera.h"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

namespace tessera {

enum class Keep { inside, outside };

/// A box along the patient's axes (mm), or along the volume's (voxels, from 0 to its extent).
struct CropBox {
    enum class Space { patient, voxels };
    glm::dvec3 low{0}, high{0}; // low below high along every axis
    Space space = Space::patient;
    Keep keep = Keep::inside;
    bool operator==(const CropBox&) const = default;
};

/// Inside is the side that the normal points to, as VTK's clipping planes have it. mm; normal of any length
/// but 0.
struct CutPlane {
    glm::dvec3 point{0}, normal{0, 0, 1};
    Keep keep = Keep::inside;
    bool operator==(const CutPlane&) const = default;
};

/// Everything that a camera sees through an outline, at any distance: a prism (parallel) or a pyramid
/// (perspective) in view space. Points behind the eye of a perspective camera are outside.
struct Scissors {
    Camera camera;
    double aspect = 1; // width / height of the picture that the outline was drawn on
    /// A polygon, closed; inside by the even-odd rule. x to the right, y down, from 0 to 1 over the picture;
    /// points may lie outside it.
    std::vector<glm::dvec2> outline;
    Keep keep = Keep::inside;
    bool operator==(const Scissors&) const = default;
};

/// These throw InputError naming where for numbers that are not finite or beyond bounds
/// (core/base/magnitude.h). They refuse a box whose low is not below its high, a normal of length 0, an
/// invalid camera, and an aspect that is not positive. They refuse outlines of fewer than 3 points or more
/// than Cuts::kMostPoints.
void checkBox(const CropBox& box, const std::string& where);
void checkPlane(const CutPlane& plane, const std::string& where);
void checkScissors(const Scissors& scissors, const std::string& where);

struct Cuts {
    std::vector<CropBox> boxes;
    std::vector<CutPlane> planes;
    std::vector<Scissors> scissors;

    static constexpr std::size_t kMostOfAKind = 16, kMostPoints = 1024;
    bool any() const { return !boxes.empty() || !planes.empty() || !scissors.empty(); }
    bool operator==(const Cuts&) const = default;
};

} // namespace tessera
