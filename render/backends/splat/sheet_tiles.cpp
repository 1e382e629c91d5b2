// render/backends/splat/sheet_tiles.cpp: see sheet_tiles.h.
#include "render/backends/splat/sheet_tiles.h"

#include "core/base/brick.h"
#include "render/contract/integrators.h"
#include "render/contract/optics.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

// The same operations in the same order, whatever the instructions: bits do not depend on the processor.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) &&     \
    !defined(__SANITIZE_THREAD__)
#define TESSERA_SPLAT_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define TESSERA_SPLAT_CLONES
#endif

namespace tessera {
namespace {

constexpr int kLanes = 8;

/// e^-t, t in [0, 4.5]: the eighth power of a series about the middle of t/8; 6e-6 of it.
inline float gaussian(float t) {
    constexpr float kMiddle = 0.28125f, kAtMiddle = 0.754839602f;
    const float d = kMiddle - 0.125f * t;
    const float p =
        kAtMiddle *
        (1 + d * (1 + d * (0.5f + d * (0.166666667f + d * (0.0416666667f + d * 0.00833333333f)))));
    const float squared = p * p, fourth = squared * squared;
    return fourth * fourth;
}

/// Lays one splat onto rows of a sheet.
/// @param low, high  pixels of the tile, high not included
/// @param depth, colours  the tile's planes
TESSERA_SPLAT_CLONES
void lay(const DrawnSplat& s, float cutOff, float left, float top, int lowX, int lowY, int highX, int highY,
         float* depth, float* red, float* green, float* blue) {
    const float squaredCutOff = cutOff * cutOff;
    for (int y = lowY; y < highY; ++y) {
        const float dy = top + static_cast<float>(y) - s.y;
        const float ofRow = s.yy * dy * dy, slope = 2 * s.xy * dy;
        for (int x = lowX & -kLanes; x < highX; x += kLanes) {
            const int at = y * kTileEdge + x;
            const float start = left + static_cast<float>(x) - s.x;
            for (int lane = 0; lane < kLanes; ++lane) {
                const float dx = start + static_cast<float>(lane);
                const float d = ofRow + dx * (slope + s.xx * dx);
                const float inside = d < squaredCutOff ? s.depth : 0.0f;
                const float q = inside * gaussian(0.5f * std::min(d, squaredCutOff));
                depth[at + lane] += q;
                red[at + lane] += q * s.red;
                green[at + lane] += q * s.green;
                blue[at + lane] += q * s.blue;
            }
        }
    }
}

} // namespace

std::size_t SheetTiles::bytes(const glm::ivec2& imageSize) {
    const glm::ivec2 grid = (imageSize + (kTileEdge - 1)) / kTileEdge;
    return static_cast<std::size_t>(grid.x) * static_cast<std::size_t>(grid.y) *
           (sizeof(Tile) + kPixels * kPlanes * sizeof(float));
}

SheetTiles::SheetTiles(const glm::ivec2& imageSize, float ends, float cutOff, SplatComposition composition,
                       MemoryBudget& budget)
    : size_(imageSize), grid_((imageSize + (kTileEdge - 1)) / kTileEdge), ends_(ends), cutOff_(cutOff),
      every_(composition == SplatComposition::every),
      charge_(budget.charge(bytes(imageSize), "the tiles of a picture of splats")),
      tiles_(static_cast<std::size_t>(grid_.x) * static_cast<std::size_t>(grid_.y)),
      numbers_(tiles_.size() * kPlanes * kPixels) {}

TileBox SheetTiles::around(const glm::vec2& low, const glm::vec2& high) const {
    // Beyond the picture by less than a tile, so that numbers fit; no number at all is all of it.
    const glm::vec2 most = glm::vec2(size_) + 1.0f;
    TileBox box;
    for (int axis = 0; axis < 2; ++axis) {
        const float from = low[axis] > 0 ? std::min(low[axis], most[axis]) : 0;
        const float to = high[axis] < most[axis] ? std::max(high[axis], 0.0f) : most[axis];
        box.low[axis] = static_cast<int>(from) / kTileEdge;
        box.high[axis] = high[axis] < 0 ? 0 : std::min(static_cast<int>(to) / kTileEdge + 1, grid_[axis]);
    }
    return box;
}

bool SheetTiles::ended(const TileBox& box) const {
    for (int y = box.low.y; y < box.high.y; ++y)
        for (int x = box.low.x; x < box.high.x; ++x)
            if (!tiles_[static_cast<std::size_t>(y * grid_.x + x)].ended)
                return false;
    return true;
}

void SheetTiles::layBehind(std::size_t tile) {
    Tile& t = tiles_[tile];
    float *const depth = plane(tile, 0), *const red = plane(tile, 1), *const green = plane(tile, 2),
                 *const blue = plane(tile, 3), *const alpha = plane(tile, 7);
    for (int y = t.low.y; y < t.high.y; ++y)
        for (int x = t.low.x; x < t.high.x; ++x) {
            const auto at = static_cast<std::size_t>(y * kTileEdge + x);
            if (!(depth[at] > 0))
                continue;
            glm::vec4 sum(plane(tile, 4)[at], plane(tile, 5)[at], plane(tile, 6)[at], alpha[at]);
            const float inverse = 1 / depth[at];
            composite(sum, glm::vec3(red[at] * inverse, green[at] * inverse, blue[at] * inverse),
                      opacityOf(depth[at]));
            for (std::size_t n = 0; n < 4; ++n) {
                plane(tile, 4 + n)[at] = sum[static_cast<int>(n)];
                plane(tile, n)[at] = 0;
            }
        }
    t.low = glm::ivec2(kTileEdge);
    t.high = glm::ivec2(0);
}

void SheetTiles::checkEnd(std::size_t tile) {
    if (!(ends_ > 0))
        return;
    const glm::ivec2 within = glm::min(size_ - firstPixel(tile), glm::ivec2(kTileEdge));
    const float* const alpha = plane(tile, 7);
    float least = 1;
    for (int y = 0; y < within.y; ++y)
        for (int x = 0; x < within.x; ++x)
            least = std::min(least, alpha[y * kTileEdge + x]);
    tiles_[tile].ended = 1 - least < ends_;
}

void SheetTiles::draw(std::size_t tile, int slice, std::span<const DrawnSplat> splats) {
    Tile& t = tiles_[tile];
    if (t.ended)
        return;
    if (t.slice != slice) {
        layBehind(tile);
        checkEnd(tile);
        t.slice = slice;
        if (t.ended)
            return;
    }
    const glm::vec2 centre = glm::vec2(firstPixel(tile)) + 0.5f; // of the tile's first pixel
    for (const DrawnSplat& s : splats) {
        const auto pixel = [](float x) {
            return static_cast<int>(std::clamp(x, -1.0f, static_cast<float>(kTileEdge)));
        };
        const int lowX = std::max(pixel(std::ceil(s.x - s.halfWidth - centre.x)), 0),
                  lowY = std::max(pixel(std::ceil(s.y - s.halfHeight - centre.y)), 0),
                  highX = std::min(pixel(std::floor(s.x + s.halfWidth - centre.x)) + 1, kTileEdge),
                  highY = std::min(pixel(std::floor(s.y + s.halfHeight - centre.y)) + 1, kTileEdge);
        if (lowX >= highX || lowY >= highY)
            continue;
        lay(s, cutOff_, centre.x, centre.y, lowX, lowY, highX, highY, plane(tile, 0), plane(tile, 1),
            plane(tile, 2), plane(tile, 3));
        t.low = glm::min(t.low, glm::ivec2(lowX, lowY));
        t.high = glm::max(t.high, glm::ivec2(highX, highY));
        if (every_)
            layBehind(tile);
    }
}

Image SheetTiles::picture() {
    Image image(size_);
    for (std::size_t tile = 0; tile < tiles_.size(); ++tile) {
        layBehind(tile);
        const glm::ivec2 first = firstPixel(tile);
        const glm::ivec2 within = glm::min(size_ - first, glm::ivec2(kTileEdge));
        for (int y = 0; y < within.y; ++y)
            for (int x = 0; x < within.x; ++x)
                for (std::size_t n = 0; n < 4; ++n)
                    image.pixels[static_cast<std::size_t>((first.y + y) * size_.x + first.x + x)]
                                [static_cast<int>(n)] =
                        plane(tile, 4 + n)[static_cast<std::size_t>(y * kTileEdge + x)];
    }
    return image;
}

} // namespace tessera
