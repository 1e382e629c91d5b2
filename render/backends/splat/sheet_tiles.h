// render/backends/splat/sheet_tiles.h: the picture in tiles, each with the sheet of the slice that is being
// drawn, and what lies before it (docs/sampling.md, "Splats"). Tiles are drawn at the same time; each takes
// its splats in their order.
#pragma once

#include "core/base/budget.h"
#include "core/image/image.h"
#include "render/backends/splat/splat_filter.h"

#include <cstddef>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

namespace tessera {

constexpr int kTileEdge = 32; // pixels

/// Tiles from low to high, high not included; of a box of pixels.
struct TileBox {
    glm::ivec2 low{0}, high{0};
    bool empty() const { return low.x >= high.x || low.y >= high.y; }
    bool holds(const glm::ivec2& tile) const {
        return tile.x >= low.x && tile.y >= low.y && tile.x < high.x && tile.y < high.y;
    }
};

class SheetTiles {
  public:
    /// @param ends  transmittance below which pixels end
    /// @param cutOff  of footprints, deviations
    SheetTiles(const glm::ivec2& imageSize, float ends, float cutOff, SplatComposition composition,
               MemoryBudget& budget);
    static std::size_t bytes(const glm::ivec2& imageSize);

    const glm::ivec2& grid() const { return grid_; }
    std::size_t count() const { return tiles_.size(); }
    /// Of a box of pixels, within the picture.
    TileBox around(const glm::vec2& low, const glm::vec2& high) const;
    /// True if nothing more shows in any tile of the box; a tile's state changes as its slices are
    /// composited.
    bool ended(const TileBox& box) const;
    bool ended(std::size_t tile) const { return tiles_[tile].ended; }

    /// Lays splats onto a tile's sheet, in their order. Of a new slice: the one before is composited first.
    void draw(std::size_t tile, int slice, std::span<const DrawnSplat> splats);
    /// Composites the last slices, and gives the picture: linear, premultiplied.
    Image picture();

  private:
    struct Tile {
        int slice = -1;
        glm::ivec2 low{kTileEdge}, high{0}; // of the sheet, pixels: what its splats touch
        bool ended = false;
    };
    /// A tile's numbers, row by row: sheet of optical depth, of red, green, blue by depth; then red, green,
    /// blue and alpha of what lies before it.
    static constexpr std::size_t kPixels = std::size_t{kTileEdge} * kTileEdge, kPlanes = 8;
    float* plane(std::size_t tile, std::size_t number) {
        return numbers_.data() + (tile * kPlanes + number) * kPixels;
    }
    void layBehind(std::size_t tile);
    void checkEnd(std::size_t tile);
    glm::ivec2 firstPixel(std::size_t tile) const {
        return glm::ivec2(static_cast<int>(tile) % grid_.x, static_cast<int>(tile) / grid_.x) * kTileEdge;
    }

    glm::ivec2 size_, grid_;
    float ends_, cutOff_;
    bool every_;
    Charge charge_;
    std::vector<Tile> tiles_;
    std::vector<float> numbers_;
};

} // namespace tessera
