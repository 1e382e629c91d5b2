// viewer/cli/modules/picture_module.cpp: the table of functions of tessera_pictures.so.
#include "viewer/cli/modules/picture_module.h"

extern "C" const tessera::PictureModule tesseraModule;
const tessera::PictureModule tesseraModule = {
    {TESSERA_VERSION},     tessera::writeImage,  tessera::writeImageRows,     tessera::readImage,
    tessera::readManifest, tessera::pictureSize, tessera::checkPictureIsWhole};
