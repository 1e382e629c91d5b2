// core/image/image.h: a picture in memory: linear light, Rec. 709 primaries, premultiplied alpha, float, top
// row first. The format of its file follows from the file's name, without a picture library.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <string>
#include <vector>

namespace tessera {

struct Image {
    glm::ivec2 size{0};
    std::vector<glm::vec4> pixels; // [y][x], x fastest, y = 0 at the top; rgb premultiplied by a

    Image() = default;
    explicit Image(const glm::ivec2& s)
        : size(s), pixels(static_cast<std::size_t>(s.x) * static_cast<std::size_t>(s.y)) {}
    glm::vec4& at(int x, int y) { return pixels[index(x, y)]; }
    const glm::vec4& at(int x, int y) const { return pixels[index(x, y)]; }

  private:
    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(size.x) + static_cast<std::size_t>(x);
    }
};

/// A channel of a layer in a picture's file, beside R, G, B and A.
struct LayerChannel {
    std::string name; // "normal.X": the layer's name, a point, the channel's
    /// Of every pixel of the picture, row by row from the top.
    const float* first = nullptr;
    std::size_t stride = 1; // floats from a pixel to the next
};

/// Rows of a picture that is given part by part, and may be larger than memory.
struct ImageRows {
    glm::ivec2 size{0};
    bool opaque = false; // no alpha is below 1
    /// So many rows from the first on, from the top down; valid until the next call.
    std::function<std::span<const glm::vec4>(int first, int count)> rows;
    /// How many are asked for at a time, at most.
    static constexpr int kAtOnce = 64;
};

/// Puts the picture on an opaque background (linear rgb); alpha becomes 1.
glm::vec4 overBackground(const glm::vec4& pixel, const glm::vec3& background);
Image overBackground(const Image& image, const glm::vec3& background);
/// A coarse grid over a picture: every stride-th pixel of every stride-th row, from the middle of the first
/// stride on. A side that is shorter than a stride has one pixel. Its size in pixels; stride >= 1.
glm::ivec2 thinnedSize(const glm::ivec2& size, int stride);
/// The pixel of the picture at a point of the grid.
/// @param at  of the grid, below thinnedSize()
glm::ivec2 thinnedPixel(const glm::ivec2& at, const glm::ivec2& size, int stride);
/// The picture's pixels on that grid, not averaged.
Image thinned(const Image& image, int stride);
/// The least alpha that an 8-bit picture could show is above this.
constexpr float kBlankAlpha = 1.0f / 510;
/// True when no pixel has alpha above kBlankAlpha.
bool isBlank(const Image& image);

enum class PictureFormat { png, exr, tiff };

/// By extension. Throws InputError naming path when it is another.
PictureFormat pictureFormat(const std::filesystem::path& path);

} // namespace tessera
