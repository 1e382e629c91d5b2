// viewer/annotations/figure_drawing.h: draws the annotations of a figure with Cairo and Pango: over a
// picture, as a picture of their own, as PDF and as SVG. It is a module of its own (viewer/cli/modules/),
// which programs load with the first annotation, PDF or SVG.
#pragma once

#include "core/base/budget.h"
#include "core/image/image.h"
#include "viewer/annotations/figure.h"

#include <filesystem>
#include <functional>
#include <glm/vec4.hpp>
#include <span>
#include <string>
#include <vector>

namespace tessera {

/// What draws, and what had no room.
struct DrawingReport {
    std::string cairo, pango; // versions
    struct Font {
        std::string family, file; // without its folder
        bool operator==(const Font&) const = default;
    };
    std::vector<Font> fonts; // of the words
    std::vector<std::string> leftOut;
};
/// Lays out the figure and draws nothing. Throws Error where there is no font.
DrawingReport describeDrawing(const Figure& figure);

/// stripsNeeded() (figure_layout.h) in the figures' font.
StripHeights measureStrips(const FigurePart& words, double dpi);

/// stripsBeside() (figure_layout.h) likewise.
Strips measureBeside(const FigurePart& part, double dpi);

/// Draws over a picture of the figure's size.
void drawAnnotations(const Figure& figure, Image& picture);
/// Draws over some rows of it, from one of them on: the same, whichever rows are drawn together.
using DrawRows = std::function<void(int first, std::span<glm::vec4> rows)>;
DrawRows annotationRows(const Figure& figure);

/// Writes an OutputFile: .pdf or .svg, by the extension.
/// @param manifest  ASCII
/// Throws Error naming path when it cannot be written, InputError for a picture that is larger than
/// kMostPagePixels along an axis.
void writePage(const std::filesystem::path& path, const Image& picture, const Figure& figure,
               const std::string& manifest, MemoryBudget& ram);
constexpr int kMostPagePixels = 32767; // of Cairo's images

} // namespace tessera
