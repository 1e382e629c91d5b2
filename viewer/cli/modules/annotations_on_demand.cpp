// viewer/cli/modules/annotations_on_demand.cpp: viewer/annotations/figure_drawing.h for programs: the first
// annotation, PDF or SVG loads Cairo and Pango.
#include "viewer/cli/modules/annotation_module.h"

namespace tessera {
namespace {

const AnnotationModule& annotationModule() {
    static const auto* const table = static_cast<const AnnotationModule*>(loadModule("tessera_annotations"));
    return *table;
}

} // namespace

DrawingReport describeDrawing(const Figure& figure) {
    return annotationModule().describe(figure);
}
StripHeights measureStrips(const FigurePart& words, double dpi) {
    return annotationModule().strips(words, dpi);
}
Strips measureBeside(const FigurePart& part, double dpi) {
    return annotationModule().beside(part, dpi);
}
void drawAnnotations(const Figure& figure, Image& picture) {
    annotationModule().draw(figure, picture);
}
DrawRows annotationRows(const Figure& figure) {
    return annotationModule().rows(figure);
}
void writePage(const std::filesystem::path& path, const Image& picture, const Figure& figure,
               const std::string& manifest, MemoryBudget& ram) {
    annotationModule().page(path, picture, figure, manifest, ram);
}

} // namespace tessera
