// core/image.cpp: see image.h.
#include "core/image.h"

#include <algorithm>

namespace tessera {

Image overBackground(const Image& image, const glm::vec3& background) {
    Image out(image.size);
    std::transform(image.pixels.begin(), image.pixels.end(), out.pixels.begin(), [&](const glm::vec4& p) {
        return glm::vec4(glm::vec3(p) + (1 - p.a) * background, 1.0f);
    });
    return out;
}

bool isBlank(const Image& image) {
    return std::all_of(image.pixels.begin(), image.pixels.end(),
                       [](const glm::vec4& p) { return !(p.a > 1.0f / 510); });
}

} // namespace tessera
