// viewer/cli/modules/picture_module.h: the functions of core/image/image_file.h, as the table of a module.
#pragma once

#include "core/image/image_file.h"
#include "viewer/cli/modules/load_module.h"

namespace tessera {

struct PictureModule {
    ModuleHead head;
    decltype(&writeImage) write;
    decltype(&writeImageRows) writeRows;
    decltype(&readImage) read;
    decltype(&readManifest) manifest;
    decltype(&pictureSize) size;
    decltype(&checkPictureIsWhole) checkIsWhole;
};

} // namespace tessera
