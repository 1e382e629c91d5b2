// tests/support/no_pictures.cpp: bricking/import/pictures/picture_rows.h for tests that read no pictures.
// Those that do link tessera_picture_rows before this.
#include "bricking/import/pictures/picture_rows.h"

#include "core/base/error.h"

namespace tessera {

std::unique_ptr<PictureRows> openPictureRows(const std::filesystem::path& file, const PictureShape&) {
    throw Error(file.string() + ": this test links no reader of pictures (tessera_picture_rows)");
}

} // namespace tessera
