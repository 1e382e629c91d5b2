// viewer/window/part_drawing.h: what a figure says about a picture, drawn over that of the window: laid out
// as in saved pictures (viewer/annotations/figure_layout.h), drawn by ImGui.
#pragma once

#include "viewer/annotations/figure.h"
#include "viewer/window/picture_view.h"

struct ImDrawList;

namespace tessera {

/// Rows at the upper and lower edges of a picture that are left to other words, in the screen's units.
constexpr double kRowOfWords = 22;

/// @param part  its camera is that of the area's whole picture; its box is set here
/// @param rows  units that are left free at the upper and at the lower edge
void drawPart(ImDrawList& draw, const Area& area, FigurePart part, double rows);

} // namespace tessera
