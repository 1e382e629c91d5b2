// render/transport/environment_map.h: light from all around as a picture of directions, and directions drawn
// by it (docs/sampling.md, "Paths": directions).
#pragma once

#include <cstddef>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

namespace tessera {

/// Directions with a density per steradian that is even within the texels of a picture by longitude and
/// latitude. Directions are unit, of the picture's own frame: x to its middle column, y to the columns right
/// of that, z to its first row.
class DirectionTable {
  public:
    /// @param size  columns, rows; 1 at least
    /// @param weights  0 or more, row by row: the density's ratios
    DirectionTable(const glm::ivec2& size, const std::vector<float>& weights);

    static std::size_t bytes(const glm::ivec2& size);
    const glm::ivec2& size() const { return size_; }
    /// False where all weights are 0: there is nothing to draw.
    bool any() const { return any_; }

    std::size_t texelOf(const glm::vec3& direction) const;
    /// Of the directions that draw() gives: exactly, whatever rounding does to the weights.
    float densityAt(std::size_t texel) const { return densities_[texel]; }

    struct Drawn {
        glm::vec3 direction{0};
        std::size_t texel = 0;
    };
    /// @param two  uniform, multiples of 2^-24 from 0 to below 1
    Drawn draw(const glm::vec2& two) const;

  private:
    glm::ivec2 size_;
    bool any_ = false;
    std::vector<float> edges_;     // heights where rows begin and the last one ends, from 1 to -1
    std::vector<float> rows_;      // sums of rows' chances up to each, from 0 to 1
    std::vector<float> columns_;   // the same within each row, a list after another
    std::vector<float> densities_; // of texels
};

/// A file's light: the same within each texel.
class EnvironmentMap {
  public:
    /// @param radiance  row by row, 0 or more
    EnvironmentMap(const glm::ivec2& size, std::vector<glm::vec3> radiance);

    static std::size_t bytes(const glm::ivec2& size);
    const DirectionTable& table() const { return table_; }
    const glm::vec3& radianceAt(std::size_t texel) const { return radiance_[texel]; }

  private:
    std::vector<glm::vec3> radiance_;
    DirectionTable table_;
};

/// As eyes weigh it, linear light.
inline float luminanceOf(const glm::vec3& radiance) {
    return 0.2126f * radiance.r + 0.7152f * radiance.g + 0.0722f * radiance.b;
}

} // namespace tessera
