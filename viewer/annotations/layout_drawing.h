// viewer/annotations/layout_drawing.h: draws a layout (figure_layout.h) with Cairo.
#pragma once

#include "viewer/annotations/figure_layout.h"
#include "viewer/annotations/pango_words.h"

#include <cairo.h>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

namespace tessera {

/// In pixels of the figure; what lies outside of a rectangle may be left out.
void drawLayout(cairo_t* cairo, const FigureLayout& layout, PangoWords& words, const glm::dvec2& from,
                const glm::dvec2& to);
/// True if anything may be drawn in a rectangle.
bool drawsWithin(const FigureLayout& layout, const glm::dvec2& from, const glm::dvec2& to);

/// The lines with their ends moved outwards, as their edges have them.
std::vector<std::vector<glm::dvec2>> lengthened(const LaidLines& lines);
/// sRGB in 8 bits, as parts of 1.
glm::dvec3 codeOfColour(const glm::vec3& linear);

} // namespace tessera
