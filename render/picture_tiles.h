// render/picture_tiles.h: PictureTiles: a picture that is drawn tile by tile, by any number of processes. The
// renderer plans the whole picture, and asks which part it is to draw (RenderOptions::tiles).
#pragma once

#include "core/image/image.h"
#include "core/image/picture_tile.h"

#include <cstddef>
#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>
#include <map>
#include <optional>
#include <string>

namespace tessera {

/// A tile as it was drawn. Pictures that there are not have no pixels.
struct DrawnTile {
    PictureTile tile;
    Image colours;
    Image added;   // to the colours once the picture's errors are known, which are those without it
    Image offsets; // of means of several samples: PixelSums::offset()
};

class PictureTiles {
  public:
    virtual ~PictureTiles() = default;

    /// Pixels along a side of a tile.
    virtual int side() const = 0;
    /// All that tiles depend on beside the scene and the engine: parts of the plan by name, in words.
    using Parts = std::map<std::string, std::string>;
    /// Before the first tile. Throws InputError for tiles that are there, and are of another plan.
    virtual void begin(const Parts& plan) = 0;
    /// The next tile that this process draws. Waits while others draw the last ones. None: all are there.
    virtual std::optional<PictureTile> next() = 0;
    virtual void keep(const DrawnTile& tile) = 0;
    /// The part of the picture that is there.
    virtual double share() const = 0;

    // After the last tile.

    /// This process makes the picture of them, and measures its errors; false: another one has.
    virtual bool finishes() const = 0;
    /// Pixels that show something, and the colours of one, without what is added.
    virtual std::size_t shown() const = 0;
    virtual glm::vec4 colour(const glm::ivec2& pixel) const = 0;
    /// All pixels of the picture, row by row: these colours, and their offsets, if there are any.
    virtual void
    eachPixel(const std::function<void(const glm::vec4& colour, const glm::vec4& offset)>& visit) const = 0;
};

} // namespace tessera
