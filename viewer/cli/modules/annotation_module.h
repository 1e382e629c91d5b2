// viewer/cli/modules/annotation_module.h: the functions of viewer/annotations/figure_drawing.h, as the table
// of a module.
#pragma once

#include "viewer/annotations/figure_drawing.h"
#include "viewer/cli/modules/load_module.h"

namespace tessera {

struct AnnotationModule {
    ModuleHead head;
    decltype(&describeDrawing) describe;
    decltype(&measureStrips) strips;
    decltype(&measureBeside) beside;
    decltype(&drawAnnotations) draw;
    decltype(&annotationRows) rows;
    decltype(&writePage) page;
};

} // namespace tessera
