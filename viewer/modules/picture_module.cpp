// viewer/modules/picture_module.cpp: what tessera_pictures.so shows.
#include "viewer/modules/picture_module.h"

extern "C" const tessera::PictureModule tesseraModule;
const tessera::PictureModule tesseraModule = {
    {TESSERA_VERSION}, tessera::writeImage, tessera::readImage, tessera::readManifest};
