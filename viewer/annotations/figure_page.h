// viewer/annotations/figure_page.h: pages of figures: pictures amid the strips on which annotations stand
// beside them (AnnotationMargin). A picture without strips is its own page.
#pragma once

#include "core/image/image.h"
#include "viewer/annotations/figure.h"

#include <cstddef>
#include <vector>

namespace tessera {

/// Strips that the part's annotations need, by the picture's size. None where nothing stands beside it.
Strips stripsOf(const FigurePart& part, double dpi);

/// The figure of one part with its strips, from (0,0) on. Throws InputError naming the option for a page of
/// longer sides than pictures have.
Figure figureOf(FigurePart part, double dpi);
/// With strips that are given.
Figure figureOf(FigurePart part, double dpi, const Strips& strips);

/// Sets the part's box and strips into a page from a corner on.
void placePart(FigurePart& part, const glm::ivec2& corner, const Strips& strips);

/// RAM of the page beside the picture; 0: the picture is its page.
std::size_t pageBytes(const Figure& figure);
/// The page of a figure of one part.
/// @param picture  of the part's size
Image onPage(Image picture, const Figure& figure);
/// The channel of a layer likewise, 0 on the strips.
/// @param values  get the page's; outlive the channel
LayerChannel onPage(const LayerChannel& channel, const Figure& figure, std::vector<float>& values);
/// Rows of the page of a figure of one part, with memory of their own for ImageRows::kAtOnce of them. The
/// figure outlives them.
/// @param picture  of the part's size
ImageRows onPage(ImageRows picture, const Figure& figure);

} // namespace tessera
