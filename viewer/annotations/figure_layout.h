// viewer/annotations/figure_layout.h: where everything goes that a figure says: lines, areas and words, as
// plain data in pixels from the figure's upper left. All of it lies within the box of its part or on
// its strips, and no two words overlap: what has no room is left out.
#pragma once

#include "viewer/annotations/figure.h"
#include "viewer/annotations/words.h"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <variant>
#include <vector>

namespace tessera {

/// Light is white with a dark edge; dark is black with a light one. Both show on anything.
enum class Ink { light, dark };

/// Lines of one kind, which cross without edges between them.
struct LaidLines {
    std::vector<std::vector<glm::dvec2>> lines; // each from point to point, its ends square
    double width = 1, edge = 1;                 // edge: on each side
    Ink ink = Ink::light;
};
/// A polygon.
struct LaidArea {
    std::vector<glm::dvec2> corners;
    glm::vec3 colour{0}; // linear light
    float opacity = 1;
};
using LaidShape = std::variant<LaidLines, LaidArea>;

/// One line of words.
struct LaidWords {
    std::string words; // UTF-8
    glm::dvec2 at{0};  // left end of the baseline
    double pixels = 0; // size of the font
    double edge = 1;   // on each side
    WordSize size;     // without the edge
    Ink ink = Ink::light;
    bool bold = false;

    glm::dvec2 from() const { return {at.x - edge, at.y - size.ascent - edge}; }
    glm::dvec2 to() const { return {at.x + size.width + edge, at.y + size.descent + edge}; }
};

struct FigureLayout {
    std::vector<LaidShape> shapes;    // in the order that they are drawn in
    std::vector<LaidWords> words;     // over them
    std::vector<std::string> leftOut; // what had no room; "the end of the title" where words are cut
};

/// In leftOut, where the scale bar is.
constexpr const char* kScaleBarWords = "the scale bar";

FigureLayout layOut(const Figure& figure, const MeasureWords& measure);

/// Strips that the part's title and caption need above and below a picture of the part's size, so that they
/// lie beside it. Their letters are those of a figure that is higher by both.
StripHeights stripsNeeded(const FigurePart& words, double dpi, const MeasureWords& measure);

/// Strips that a part's annotations need to stand beside its picture, by the picture's size. None where they
/// lie over it.
Strips stripsBeside(const FigurePart& part, double dpi, const MeasureWords& measure);

/// The size of a part's letters, pixels: as asked, but smaller in a small picture.
double letterPixels(const FigurePart& part, double dpi);

} // namespace tessera
