// core/image/picture_format.cpp: see picture_format.h.
#include "core/image/picture_format.h"

#include "core/base/error.h"

#include <algorithm>
#include <cctype>

namespace tessera {

PictureFormat pictureFormat(const std::filesystem::path& path) {
    std::string extension = path.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (extension == ".png")
        return PictureFormat::png;
    if (extension == ".exr")
        return PictureFormat::exr;
    if (extension == ".tif" || extension == ".tiff")
        return PictureFormat::tiff;
    throw badFile(path.string(), "a picture's name ending in .png, .exr, .tif or .tiff",
                  extension.empty() ? "no extension" : "\"" + extension + "\"");
}

} // namespace tessera
