// viewer/annotations/figure_drawing.cpp: see figure_drawing.h.
#include "viewer/annotations/figure_drawing.h"

#include "core/base/error.h"

namespace tessera {

DrawingReport describeDrawing(const Figure&) {
    return {};
}

void drawAnnotations(const Figure&, Image&) {}

void writePage(const std::filesystem::path& path, const Image&, const Figure&, const std::string&,
               MemoryBudget&) {
    throw Error(path.string() + ": cannot be written: not yet");
}

} // namespace tessera
