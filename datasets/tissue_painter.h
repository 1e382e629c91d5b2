// datasets/tissue_painter.h: paints a list of tissues into voxels, later tissues over earlier ones, every
// surface blended over one voxel. Tiles of a slice are pruned against the tissues' bounds first. Most voxels
// then see only the one or two surfaces that pass near them.
#pragma once

#include "datasets/shapes.h"

#include <deque>
#include <span>

namespace tessera {

/// Where the tissue's distance is at most offsetMm the value becomes hu.
struct Shell {
    float offsetMm, hu;
};

/// The union of shapes, cut to a clip shape, filled in shells (offsets descending: each is inside the one
/// before).
struct Tissue {
    ShapeList shapes;
    std::vector<Shell> shells;
    float smoothMm = 0;                     ///< width over which shapes of the union are blended
    std::shared_ptr<const Shape> clip = {}; ///< nothing is painted outside; null: no clip
    float clipOffsetMm = 0;                 ///< moves the clip's surface; negative is inwards
};

class TissuePainter {
  public:
    /// @param blendMm  width of every surface's transition, mm, > 0
    TissuePainter(std::deque<Tissue> tissues, float backgroundHu, float blendMm);

    /// The value at one point, from every tissue: the slow reference that slice() must equal up to rounding.
    float valueAt(const glm::vec3& p) const;
    /// Values on a grid of nx * ny points, x fastest: point (i,j) at first + (i*stepX, j*stepY, 0).
    void slice(const glm::vec3& first, float stepX, float stepY, int nx, int ny, std::span<float> out) const;

  private:
    /// An entry of a tile: a shape of a tissue, or the tissue's clip, or (shape null) a shell of the tissue
    /// that fills the tile.
    struct Active {
        const Tissue* tissue;
        const Shape* shape;
        std::size_t shell;
    };
    float paint(std::span<const Active> active, const glm::vec3& p) const;
    /// Keeps the entries of `from` (grouped by tissue, in painting order) that affect the ball.
    void prune(std::span<const Active> from, const glm::vec3& centre, float radius,
               std::vector<Active>& kept) const;

    std::deque<Tissue> tissues_;
    std::vector<Active> all_;
    std::vector<Box> boxes_; // of all_, grown by what its tissue paints around it
    float backgroundHu_, halfBlendMm_;
};

} // namespace tessera
