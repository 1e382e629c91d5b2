// core/scene/annotations.h: what a figure shows over its picture: a scale bar, the patient's directions,
// legends, measurements, arrows and words.
#pragma once

#include "core/base/names.h"

#include <cstddef>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

/// The patient's directions: letters at the picture's edges (R, L, A, P, S, I), a cube with them, or both.
enum class Directions { none, letters, cube, all };
template <> const NameTable<Directions>& namesOf<Directions>();

/// What stands beside the picture, on strips around it, in place of over it: nothing; the legends, at the
/// right; or all that has no place in the patient.
enum class AnnotationMargin { none, legends, all };
template <> const NameTable<AnnotationMargin>& namesOf<AnnotationMargin>();

/// An arrow to a place in the patient, with words at its other end.
struct Arrow {
    static constexpr std::size_t kMost = 100; // of a scene
    glm::dvec3 place{0};                      // of its tip, mm, patient space (LPS)
    glm::dvec2 offset{24, -24};               // of its other end, points; x to the right, y down
    std::string text;
    bool operator==(const Arrow&) const = default;
};

struct Annotations {
    static constexpr std::size_t kMostLetters = 1000; // of the title, the caption and the words of an arrow
    bool scaleBar = false;
    Directions directions = Directions::none;
    bool legend = false;       // colours by value, or the window of greys
    bool labelLegend = false;  // of the labels that are drawn
    bool measurements = false; // the scene's
    bool error = false;        // the measured error, in the caption
    std::string title, caption;
    std::vector<Arrow> arrows;
    AnnotationMargin margin = AnnotationMargin::none;
    std::optional<glm::vec3> marginColour; // of the strips, linear; none: that of the background
    double textPoints = 9;                 // height of letters, 1/72 inch
    double dpi = 96;                       // pixels per inch of the figure

    bool operator==(const Annotations&) const = default;
    /// True if a picture has any.
    bool any() const;
    /// True if the title, the caption or an arrow has kPhasePlace.
    bool namesPhase() const;
    /// Sets a phase's label into all of these places. False: words would grow too long, and stay.
    bool namePhase(const std::string& label);
};

/// In words: the label of the phase of the scene's first volume, "phase 40 %", "2.5 s".
constexpr const char* kPhasePlace = "{phase}";

} // namespace tessera
