// viewer/cli/modules/annotation_module.cpp: the table of functions of tessera_annotations.so.
#include "viewer/cli/modules/annotation_module.h"

extern "C" const tessera::AnnotationModule tesseraModule;
const tessera::AnnotationModule tesseraModule = {
    {TESSERA_VERSION},        tessera::describeDrawing, tessera::measureStrips, tessera::measureBeside,
    tessera::drawAnnotations, tessera::annotationRows,  tessera::writePage};
