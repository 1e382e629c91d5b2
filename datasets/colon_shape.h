// datasets/colon_shape.h: the colon as a shape: a tube along a smooth centre-line. Three rows of thin
// semilunar folds between three taeniae pouch its lumen into haustra.
#pragma once

#include "datasets/shapes.h"

namespace tessera {

/// The course of the colon, from caecum to rectum, by formulas, at any spacing.
class ColonCourse {
  public:
    /// @param collapsed  with the closed piece of phantom.h
    explicit ColonCourse(bool collapsed = false);
    struct Station {
        glm::vec3 at, normal, binormal; ///< point and rotation-minimising frame on the course
    };
    const std::vector<Station>& stations() const { return stations_; } ///< kStationMm apart
    bool collapsed() const { return collapsed_; }
    float lengthMm() const { return lengthMm_; }
    float stationMm() const { return stationMm_; }
    Station atArc(float arcMm) const;
    /// Radius without folds and pouches.
    static float radiusMm(float arcFraction);
    /// Lumen radius in the direction (cosine, sine) around the course, and its slope along it. Negative where
    /// the colon is closed, so that no point is inside.
    struct Lumen {
        float radiusMm, slope;
    };
    Lumen lumen(float arcMm, float cosine, float sine, bool withFolds) const;

  private:
    void close(Lumen& lumen, float arcMm, float closedMm) const;

    std::vector<Station> stations_;
    bool collapsed_;
    float lengthMm_ = 0, stationMm_ = 2;
};

/// Finds the nearest point on the course with a grid of cells that list the stations near them.
class ColonGrid {
  public:
    explicit ColonGrid(std::shared_ptr<const ColonCourse> course);
    struct Nearest {
        float arcMm, distanceMm;
        std::size_t station; ///< the segment from this station to the next ...
        float t;             ///< ... at this fraction
    };
    /// False where the course is farther than kReachMm.
    bool nearest(const glm::vec3& p, Nearest& found) const;
    const ColonCourse& course() const { return *course_; }
    Box box() const { return {low_, low_ + glm::vec3(cells_) * kCellMm}; }

    static constexpr float kReachMm = 44;

  private:
    static constexpr float kCellMm = 7;
    std::shared_ptr<const ColonCourse> course_;
    glm::vec3 low_;
    glm::ivec3 cells_;
    std::vector<std::uint32_t> firstOfCell_; // into candidates_, one more than cells
    std::vector<std::uint16_t> candidates_;  // stations that can be the nearest to a point of the cell
};

/// The solid inside the colon's wall: with the folds cut out it is the lumen, without them it
/// bounds the wall.
class Colon final : public Shape {
  public:
    Colon(std::shared_ptr<const ColonGrid> grid, bool withFolds)
        : grid_(std::move(grid)), withFolds_(withFolds) {}
    float distance(const glm::vec3& p) const override;
    Range bounds(const glm::vec3& c, float r) const override;
    Box box() const override { return grid_->box(); }

  private:
    std::shared_ptr<const ColonGrid> grid_;
    bool withFolds_;
};

} // namespace tessera
