// core/image/image.cpp: see image.h.
#include "core/image/image.h"

#include "core/base/error.h"

#include <algorithm>
#include <cctype>
#include <glm/common.hpp>

namespace tessera {

glm::vec4 overBackground(const glm::vec4& pixel, const glm::vec3& background) {
    return {glm::vec3(pixel) + (1 - pixel.a) * background, 1.0f};
}

Image overBackground(const Image& image, const glm::vec3& background) {
    Image out(image.size);
    std::transform(image.pixels.begin(), image.pixels.end(), out.pixels.begin(),
                   [&](const glm::vec4& p) { return overBackground(p, background); });
    return out;
}

glm::ivec2 thinnedSize(const glm::ivec2& size, int stride) {
    return glm::max(size / stride, glm::ivec2(1));
}

glm::ivec2 thinnedPixel(const glm::ivec2& at, const glm::ivec2& size, int stride) {
    return glm::min(at * stride + stride / 2, size - 1);
}

Image thinned(const Image& image, int stride) {
    Image out(thinnedSize(image.size, stride));
    for (int y = 0; y < out.size.y; ++y)
        for (int x = 0; x < out.size.x; ++x) {
            const glm::ivec2 from = thinnedPixel({x, y}, image.size, stride);
            out.at(x, y) = image.at(from.x, from.y);
        }
    return out;
}

bool isBlank(const Image& image) {
    return std::all_of(image.pixels.begin(), image.pixels.end(),
                       [](const glm::vec4& p) { return !(p.a > kBlankAlpha); });
}

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
