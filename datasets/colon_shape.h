// datasets/colon_shape.h: the colon as a shape: a tube along a smooth centre-line whose lumen is pouched into
// haustra by three rows of thin semilunar folds between three taeniae.
#pragma once

#include "datasets/shapes.h"

namespace tessera {

/// The course of the colon, from caecum to rectum; all of it follows from formulas, at any spacing.
class ColonCourse {
  public:
    ColonCourse();
    struct Station {
        glm::vec3 at, normal, binormal; ///< point and frame that does not twist along the course
    };
    const std::vector<Station>& stations() const { return stations_; } ///< kStationMm apart
    float lengthMm() const { return lengthMm_; }
    float stationMm() const { return stationMm_; }
    Station atArc(float arcMm) const;
    /// Radius without folds and pouches.
    static float radiusMm(float arcFraction);
    /// Lumen radius in the direction (cosine, sine) around the course, and its slope along it.
    struct Lumen {
        float radiusMm, slope;
    };
    Lumen lumen(float arcMm, float cosine, float sine, bool withFolds) const;

  private:
    std::vector<Station> stations_;
    float lengthMm_ = 0, stationMm_ = 2;
};

class Colon final : public Shape {
  public:
    Colon(std::shared_ptr<const ColonCourse> course, bool withFolds);
    float distance(const glm::vec3& p) const override;
    Range bounds(const glm::vec3& c, float r) const override;
    Box box() const override { return {low_, low_ + glm::vec3(cells_) * kCellMm}; }

  private:
    struct Nearest {
        float arcMm, distanceMm;
        std::size_t station;
        float t;
    };
    bool nearest(const glm::vec3& p, Nearest& found) const;

    static constexpr float kCellMm = 10;
    static constexpr float kReachMm = 44; // beyond, the distance is only known to be large
    std::shared_ptr<const ColonCourse> course_;
    bool withFolds_;
    glm::vec3 low_;
    glm::ivec3 cells_;
    std::vector<std::uint32_t> firstOfCell_; // into candidates_, one more than cells
    std::vector<std::uint16_t> candidates_;  // segments that can be the nearest to a point of the cell
};

} // namespace tessera
