// render/contract/cache_field.h: the field of a selection of bricks, read through the brick cache. For one
// thread at a time.
#pragma once

#include "render/contract/lattice.h"
#include "render/contract/sampler.h"

namespace tessera {

template <typename Real> struct UniformField {
    LatticeReader& samples;
    Real samplesPerVoxel;
    Gradient kind;
    Real value(const glm::vec<3, Real>& p) { return fieldValue(samples, p, samplesPerVoxel); }
    Real pitch(const glm::vec<3, Real>&) const { return Real(1) / samplesPerVoxel; }
    glm::vec<3, Real> gradient(const glm::vec<3, Real>& p) {
        return fieldGradient(samples, p, samplesPerVoxel, kind);
    }
};

template <typename Real> struct MixedField {
    MixedReader& samples;
    Gradient kind;
    Real value(const glm::vec<3, Real>& p) { return interblockValue(samples, p); }
    /// Of the brick that p lies in.
    Real pitch(const glm::vec<3, Real>& p) {
        const LevelMap& map = samples.map();
        const auto place = cornerPlace(p, glm::vec<3, Real>(map.extentVoxels), map.bricks);
        const std::uint32_t code = map.at(place.corner).code(place.current);
        return static_cast<Real>(1 << (code == BrickCorner::kEmpty ? map.finest : code));
    }
    glm::vec<3, Real> gradient(const glm::vec<3, Real>& p) { return interblockGradient(samples, p, kind); }
};

/// visit(field).
/// @param levels  of mixed levels; null: the selection has one
template <typename Real, typename Visit>
void withCacheField(BrickCache& cache, const VolumeInfo& info, const Selection& selection,
                    const LevelMap* levels, Gradient kind, const Visit& visit) {
    if (levels) {
        MixedReader samples(cache, info, selection, *levels);
        MixedField<Real> field{samples, kind};
        visit(field);
    } else {
        const int level = selection.finest();
        LatticeReader samples(cache, info, level, &selection);
        UniformField<Real> field{samples, Real(1) / static_cast<Real>(1 << level), kind};
        visit(field);
    }
}

} // namespace tessera
