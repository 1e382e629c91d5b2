// viewer/annotations/figure_file.h: figures as files: PNG, TIFF and EXR as image_file.h writes them; PDF and
// SVG, the picture in them without loss, lines and words over it. The first annotation and the first PDF or
// SVG load what draws them.
#pragma once

#include "core/base/budget.h"
#include "core/image/image.h"
#include "core/scene/scene.h"
#include "viewer/annotations/figure.h"

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

namespace tessera {

/// Throws InputError naming path when its extension is not one that writeFigure() knows.
void checkFigurePath(const std::filesystem::path& path);
/// Throws InputError naming the option for annotations that ask for what the scene does not have, or where
/// the program has none.
void checkAnnotations(const Scene& scene);

/// Adds to a manifest what the parts of a figure say: "annotations" (fonts, libraries, and what had no room:
/// "leftOut"), and of a figure of one part "scaleBar" and "legend".
void tellAnnotations(nlohmann::json& manifest, const Figure& figure);
/// "not in the picture: the title; ..."; "" where all is.
std::string leftOutText(const nlohmann::json& manifest);

/// Strips above and below a picture of the part's size in which the part's title and caption have room.
StripHeights heightsOf(const FigurePart& words, double dpi);

/// Puts a picture, on its background, on the figure's page (figure_page.h), and draws the annotations.
/// @param picture  of the figure's size, or of its one part's
void annotate(Image& picture, const Figure& figure);

/// Writes an OutputFile. PNG and TIFF have the annotations in the picture, and its dpi. EXR has the picture
/// as it is and the annotations as a layer of their own (annotations.R, G, B, A). A page of a PDF has the
/// figure's size: pixels / dpi inches.
/// @param picture  of the figure's size or of its one part's, on its background; PNG and TIFF are drawn in it
/// @param manifest  JSON text in ASCII, which readManifest() gives back
/// @param layers  EXR alone has them
/// Throws Error naming path when it cannot be written, InputError for a picture that is too large for PDF
/// and SVG.
void writeFigure(const std::filesystem::path& path, Image picture, const Figure& figure,
                 const std::string& manifest, std::span<const LayerChannel> layers, MemoryBudget& ram);

/// The same file as writeFigure()'s, of a picture that is given row by row; no page.
/// @param given  picture, of the size of the figure's one part, on its background
/// @param ram  charged for rows, some of which are in memory beside the picture's own
void writeFigureRows(const std::filesystem::path& path, const ImageRows& given, const Figure& figure,
                     const std::string& manifest, MemoryBudget& ram);

} // namespace tessera
