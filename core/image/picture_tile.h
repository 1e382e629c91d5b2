// core/image/picture_tile.h: a part of a picture, and pictures that are drawn part by part: squares, those at
// the right and the lower edge smaller.
#pragma once

#include <algorithm>
#include <cstddef>
#include <glm/common.hpp>
#include <glm/vec2.hpp>
#include <vector>

namespace tessera {

/// Pixels of a picture.
struct PictureTile {
    glm::ivec2 from{0}, size{0};

    std::size_t pixels() const { return static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y); }
    /// The same with so many pixels around it, as far as the picture goes.
    PictureTile with(int margin, const glm::ivec2& picture) const {
        const glm::ivec2 low = glm::max(from - margin, glm::ivec2(0));
        return {low, glm::min(from + size + margin, picture) - low};
    }
    /// The middles of its pixels on the picture, row by row.
    std::vector<glm::vec2> middles() const {
        std::vector<glm::vec2> places;
        places.reserve(pixels());
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x)
                places.push_back(glm::vec2(from + glm::ivec2(x, y)) + 0.5f);
        return places;
    }
    friend bool operator==(const PictureTile&, const PictureTile&) = default;
};

/// The tiles of a picture, by number: row by row from the top.
class TileGrid {
  public:
    /// @param side  of a tile, pixels
    TileGrid(const glm::ivec2& picture, int side)
        : picture_(picture), side_(side), across_((picture + (side - 1)) / side) {}
    std::size_t count() const {
        return static_cast<std::size_t>(across_.x) * static_cast<std::size_t>(across_.y);
    }
    PictureTile at(std::size_t number) const {
        const auto n = static_cast<int>(number);
        const glm::ivec2 from = glm::ivec2(n % across_.x, n / across_.x) * side_;
        return {from, glm::min(glm::ivec2(side_), picture_ - from)};
    }
    /// The number of a pixel's tile.
    std::size_t numberOf(const glm::ivec2& pixel) const {
        const glm::ivec2 tile = pixel / side_;
        return static_cast<std::size_t>(tile.y) * static_cast<std::size_t>(across_.x) +
               static_cast<std::size_t>(tile.x);
    }
    const glm::ivec2& picture() const { return picture_; }
    int side() const { return side_; }
    /// Columns and rows of tiles.
    const glm::ivec2& across() const { return across_; }

  private:
    glm::ivec2 picture_;
    int side_;
    glm::ivec2 across_;
};

} // namespace tessera
