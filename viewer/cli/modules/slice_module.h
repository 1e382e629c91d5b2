// viewer/cli/modules/slice_module.h: the function of bricking/import/pictures/picture_rows.h, as the table of
// a module.
#pragma once

#include "bricking/import/pictures/picture_rows.h"
#include "viewer/cli/modules/load_module.h"

namespace tessera {

struct SliceModule {
    ModuleHead head;
    decltype(&openPictureRows) open;
};

} // namespace tessera
