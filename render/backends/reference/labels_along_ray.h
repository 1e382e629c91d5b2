// render/backends/reference/labels_along_ray.h: labels along a ray through one cell of the field
// (docs/sampling.md, "Labels"), where every factor is a cubic.
#pragma once

#include "render/backends/reference/cell_gradients.h"
#include "render/backends/reference/cells_on_ray.h"
#include "render/contract/leaves.h"
#include "render/contract/optics.h"
#include "render/labels/label_field.h"

#include <algorithm>
#include <array>
#include <glm/vec3.hpp>

namespace tessera {

/// Voxels between the planes that cut rays: the samples' middles, their faces where labels have nearest
/// borders, and those of gradients.
inline double planesOf(const Optics& optics, bool takesGradients) {
    const double labels = optics.labels.nearest ? 0.5 : 1.0;
    return takesGradients ? std::min(labels, planesOfGradient(optics.gradient)) : labels;
}

class LabelsAlongRay {
  public:
    /// @param position  by parameter, voxels
    template <typename Position>
    LabelsAlongRay(LabelField& field, const Position& position, double ta, double tb)
        : numbers_(field.labels().numbers()) {
        std::array<leaf::LabelShares<double>, 4> at;
        if (numbers_.nearest)
            at.fill(field.shares(position(0.5 * (ta + tb))));
        else
            for (std::size_t i = 0; i < at.size(); ++i)
                at[i] = field.shares(placeAt(position, ta, tb, i));
        const auto along = [&](double leaf::LabelShares<double>::*part) {
            return Cubic(at[0].*part, at[1].*part, at[2].*part, at[3].*part);
        };
        using Shares = leaf::LabelShares<double>;
        cubics_ = {along(&Shares::plain), along(&Shares::tinted), along(&Shares::solid),
                   along(&Shares::dense), along(&Shares::red),    along(&Shares::green),
                   along(&Shares::blue)};
        for (const Shares& shares : at)
            hasMedium_ = hasMedium_ || shares.solid > 0;
    }

    bool hasMedium() const { return hasMedium_; }
    template <typename V> leaf::LabelShares<V> at(V u) const {
        return {cubics_[0](u), cubics_[1](u), cubics_[2](u), cubics_[3](u),
                cubics_[4](u), cubics_[5](u), cubics_[6](u)};
    }
    /// Extinctions of the function's share, and of the medium.
    template <typename V> V function(V u, V extinction) const {
        return leaf::labelledFunction(at(u), extinction);
    }
    template <typename V> V medium(V u) const {
        return leaf::labelledMedium(at(u), V(static_cast<double>(numbers_.density)));
    }
    /// Kinks of the medium, from 0 to 1: where its share is that of its border.
    template <typename Visit> void forEachBorder(const Visit& visit) const {
        std::array<double, 4> ends{};
        const Cubic& solid = cubics_[2];
        const std::size_t count = hasMedium_ ? solid.monotonePieces(ends) : 0;
        const double border{leaf::kLabelBorder};
        for (std::size_t i = 0; i + 1 < count; ++i)
            if ((solid(ends[i]) < border) != (solid(ends[i + 1]) < border))
                visit(crossing(solid, border, ends[i], ends[i + 1]));
    }
    bool hasColour() const { return numbers_.colour >= 0; }

    /// The gradient of the medium, patient space, at ta, two points between and tb.
    template <typename Position>
    static std::array<glm::dvec3, 4> gradients(LabelField& field, const Optics& optics,
                                               const Position& position, double ta, double tb) {
        const glm::dmat3 toPatient(optics.voxelFromPatientTransposed);
        std::array<glm::dvec3, 4> all;
        for (std::size_t i = 0; i < all.size(); ++i)
            all[i] = toPatient * field.gradient(placeAt(position, ta, tb, i));
        return all;
    }

  private:
    template <typename Position>
    static glm::dvec3 placeAt(const Position& position, double ta, double tb, std::size_t third) {
        return third == 3 ? position(tb) : position(ta + (tb - ta) * static_cast<double>(third) / 3);
    }

    const leaf::LabelNumbers& numbers_;
    std::array<Cubic, 7> cubics_ = {Cubic(0, 0, 0, 0), Cubic(0, 0, 0, 0), Cubic(0, 0, 0, 0),
                                    Cubic(0, 0, 0, 0), Cubic(0, 0, 0, 0), Cubic(0, 0, 0, 0),
                                    Cubic(0, 0, 0, 0)};
    bool hasMedium_ = false;
};

} // namespace tessera
