// core/image/picture_format.h: the format of a picture, by its file name. It needs no picture library.
#pragma once

#include <filesystem>

namespace tessera {

enum class PictureFormat { png, exr, tiff };

/// By extension. Throws InputError naming path when it is another.
PictureFormat pictureFormat(const std::filesystem::path& path);

} // namespace tessera
