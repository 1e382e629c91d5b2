// viewer/annotations/figure.h: a figure: a picture, or several in one, each with what its scene says about it
// (core/scene/annotations.h). Plain data: where all of it goes is in figure_layout.h, the drawing in
// figure_drawing.h, the files in figure_file.h.
#pragma once

#include "core/scene/annotations.h"
#include "core/scene/camera.h"
#include "core/scene/colour_legend.h"
#include "core/scene/measurement.h"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

constexpr double kPointsPerInch = 72;

/// A label that shows.
struct LegendLabel {
    std::string name;
    glm::vec3 colour{1}; // linear light
};

/// A slice or a slab, in patient space.
struct ShownPlane {
    glm::dvec3 point{0}, normal{0, 0, 1}; // mm; unit
    double halfMm = 0;                    // to either side
};

/// A tick at either side of a picture, and words beside the left one.
struct SideTick {
    double at = 0; // pixels from the picture's upper edge
    std::string words;
};
/// One of several pictures that a part holds side by side.
struct InnerPicture {
    glm::ivec2 from{0}, size{0};          // its box in the part, pixels
    std::string words;                    // at its upper left; in the middle where letters stand there
    std::string left, right, top, bottom; // the patient's directions, in the middle of its edges
    bool lettersOnTop = false;            // left and right in its upper corners: they hold there alone
    std::vector<SideTick> ticks;
};

/// Strips around a picture, on which annotations stand beside it, pixels.
struct Strips {
    int left = 0, right = 0, above = 0, below = 0;
    bool operator==(const Strips&) const = default;
    glm::ivec2 corner() const { return {left, above}; } // the picture's, from that of the strips
    glm::ivec2 size() const { return {left + right, above + below}; }
    bool any() const { return *this != Strips(); }
};
/// Room for both.
Strips larger(const Strips& a, const Strips& b);

/// One picture of a figure. What its annotations ask for is drawn within its box, and what stands beside it
/// (AnnotationMargin) on its strips.
struct FigurePart {
    glm::ivec2 from{0}, size{0}; // its box in the figure, pixels from the upper left; not empty
    Camera camera;               // as used, of a picture as large as the box
    /// Their dpi counts only as the figure's.
    Annotations annotations;
    bool orientationKnown = true; // else there are no letters
    bool onLight = false;         // the picture's background is light: words are dark with a light edge
    std::vector<LegendBar> legend;
    std::vector<LegendLabel> labels;
    std::vector<Measurement> measurements;
    std::vector<std::string> values; // of the first of them, a line each about the volume's values in it; ""
    std::optional<ShownPlane> plane; // of a slice: measurements and arrows that lie beside it are left out
    std::string error;               // for the caption: what was measured
    std::string mark;                // of a panel: "A"; bold, in the upper left corner
    std::vector<InnerPicture> inner;
    Strips strips;               // around the box; within the figure
    glm::vec4 stripColour{0};    // linear, premultiplied
    bool stripsAreLight = false; // as onLight
};
/// Strips of the words that a figure's panels share, above and below them, pixels.
struct StripHeights {
    int above = 0, below = 0;
    bool operator==(const StripHeights&) const = default;
};

/// The option, or the key where there is none, that asks for the first of them; "" none.
std::string firstAnnotation(const Annotations& annotations);

/// True of a background that is nearer to white than to black for the eye.
/// @param background  linear; none: transparent, which is dark
bool isLight(const std::optional<glm::vec3>& background);

struct Figure {
    glm::ivec2 size{0};
    double dpi = 96; // pixels per inch
    std::vector<FigurePart> parts;

    /// True if anything is drawn over the picture.
    bool any() const;
};

} // namespace tessera
