// viewer/modules/picture_module.h: the functions of core/image_file.h as a module has them.
#pragma once

#include "core/image_file.h"
#include "viewer/modules/load_module.h"

namespace tessera {

struct PictureModule {
    ModuleHead head;
    decltype(&writeImage) write;
    decltype(&readImage) read;
    decltype(&readManifest) manifest;
};

} // namespace tessera
